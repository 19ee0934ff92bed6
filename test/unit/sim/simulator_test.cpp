#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::sim {
namespace {

RobotModel frugalBot() { return loadRobot(std::string(FRUGAL_NAV_SOURCE_DIR) + "/urdf/frugal_bot.urdf"); }

/// A box with a drawn mesh and a solid shape.
Model box(Scene& scene, const std::string& name, const Eigen::Vector3d& size_m,
          const Eigen::Vector3d& centre_m) {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                               (corner & 4) != 0 ? 0.5 : -0.5);
    mesh.vertices.emplace_back(sign.cwiseProduct(size_m).cast<float>());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  Model model;
  model.name = name;
  model.world_from_model.translation() = centre_m;
  model.visuals.push_back({static_cast<int>(scene.meshes.size()), Eigen::Isometry3d::Identity()});
  scene.meshes.push_back(mesh);
  Collision collision;
  collision.size_m = size_m;
  model.collisions.push_back(collision);
  return model;
}

/// A floor, and a wall whose near face lies at x = 1 m.
Scene wallScene() {
  Scene scene;
  scene.name = "wall";
  scene.materials.emplace_back();
  scene.models.push_back(box(scene, "floor", {20, 20, 0.1}, {0, 0, -0.05}));
  scene.models.push_back(box(scene, "wall", {0.2, 6, 1}, {1.1, 0, 0.5}));
  return scene;
}

SimulatorParams quiet() {
  SimulatorParams params;
  params.body.slip_scale = 0.0;
  params.command_timeout_s = 1e6;
  return params;
}

/// Runs and gives all contacts.
std::vector<Contact> run(Simulator& simulator, double duration_s) {
  std::vector<Contact> contacts;
  for (int i = 0; i < std::lround(duration_s / toSeconds(kPhysicsStep)); ++i) {
    const SimOutput output = simulator.step();
    contacts.insert(contacts.end(), output.contacts.begin(), output.contacts.end());
  }
  return contacts;
}

/// Everything a run's sensors gave, as bytes.
std::string bytesOf(Simulator& simulator, double duration_s) {
  std::string bytes;
  const auto add = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (int i = 0; i < std::lround(duration_s / toSeconds(kPhysicsStep)); ++i) {
    const SimOutput output = simulator.step();
    if (output.ticks) add(output.ticks->left);
    if (output.imu) {
      for (int axis = 0; axis < 3; ++axis) add(output.imu->acceleration_mps2[axis]);
    }
    if (output.scan) {
      for (const float range : output.scan->ranges_m) add(range);
    }
  }
  return bytes;
}

TEST(Simulator, EachSensorComesAtItsRate) {
  SimulatorParams params = quiet();
  params.lidar.rate_hz = 10.0;
  Simulator simulator(wallScene(), frugalBot(), params, 1, {});
  int ticks = 0, imus = 0, scans = 0;
  for (int i = 0; i < 400; ++i) {
    const SimOutput output = simulator.step();
    ticks += output.ticks ? 1 : 0;
    imus += output.imu ? 1 : 0;
    scans += output.scan ? 1 : 0;
    if (output.scan) {
      ASSERT_TRUE(output.ticks) << "a scan falls on an instant of the encoders";
      EXPECT_EQ(output.scan->stamp, output.stamp);
    }
  }
  EXPECT_EQ(simulator.stamp(), kStartTime + std::chrono::seconds(2));
  EXPECT_EQ(ticks, 100);
  EXPECT_EQ(imus, 200);
  EXPECT_EQ(scans, 20);
}

TEST(Simulator, ScanPeriodIsAWholeNumberOfEncoderPeriods) {
  SimulatorParams params = quiet();
  params.lidar.rate_hz = 7.5;
  EXPECT_EQ(Simulator(wallScene(), frugalBot(), params, 1, {}).scanPeriod(), std::chrono::milliseconds(140));
}

TEST(Simulator, ScanSeesTheWallFromTheLaser) {
  SimulatorParams params = quiet();
  params.lidar.sigma_ratio = params.lidar.sigma_min_m = params.lidar.dropout_probability = 0.0;
  Simulator simulator(wallScene(), frugalBot(), params, 1, {0.3, 0.0, 0.0});
  std::optional<LaserScan> scan;
  while (!scan) scan = simulator.step().scan;
  // The laser sits 0.02 m ahead of base_link; beam 180 of 360 from -pi looks ahead.
  EXPECT_NEAR(scan->ranges_m[180], 1.0 - 0.3 - 0.02, 1e-4);
}

TEST(Simulator, StopsAtTheWallTouchesItOnceAndDrivesAway) {
  Simulator simulator(wallScene(), frugalBot(), quiet(), 1, {});
  simulator.setCommand({0.5, 0.0});
  const std::vector<Contact> contacts = run(simulator, 6.0);
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].other, "wall");
  EXPECT_EQ(contacts[0].robot_link, "body_link");
  EXPECT_TRUE(contacts[0].driven_into);
  EXPECT_NEAR(contacts[0].speed_mps, 0.5, 0.01);
  // The body's front lies 0.12 m ahead of base_link.
  EXPECT_NEAR(simulator.groundTruth().world_from_base.x_m, 1.0 - 0.12, 1e-3);
  EXPECT_LE(simulator.groundTruth().world_from_base.x_m, 1.0 - 0.12 + 1e-4);

  simulator.setCommand({-0.5, 0.0});
  EXPECT_TRUE(run(simulator, 1.0).empty());
  EXPECT_LT(simulator.groundTruth().world_from_base.x_m, 0.6);

  simulator.setCommand({0.5, 0.0});
  EXPECT_EQ(run(simulator, 3.0).size(), 1U);
  EXPECT_EQ(simulator.contactCount(), 2);
}

TEST(Simulator, ABlockedRobotsWheelsStand) {
  SimulatorParams params = quiet();
  Simulator simulator(wallScene(), frugalBot(), params, 1, {0.8, 0.0, 0.0});
  simulator.setCommand({0.5, 0.0});
  run(simulator, 2.0);
  std::optional<WheelTicks> first, last;
  for (int i = 0; i < 400; ++i) {
    const SimOutput output = simulator.step();
    if (output.ticks) (first ? last : first) = output.ticks;
  }
  EXPECT_LE(last->left - first->left, 1);
}

TEST(Simulator, DoesNotPassThroughAtFullSpeed) {
  SimulatorParams params = quiet();
  params.body.max_wheel_speed_mps = 2.5;
  params.body.max_wheel_acceleration_mps2 = 20.0;
  Simulator simulator(wallScene(), frugalBot(), params, 1, {-3.0, 0.0, 0.2});
  simulator.setCommand({2.0, 0.0});
  EXPECT_EQ(run(simulator, 5.0).size(), 1U);
  EXPECT_LT(simulator.groundTruth().world_from_base.x_m, 1.0);
}

TEST(Simulator, AnObstacleThatComesToAStandingRobotIsNotDrivenInto) {
  Scene scene = wallScene();
  scene.models.push_back(box(scene, "cart", {0.2, 0.2, 0.5}, {-1.0, 0, 0.25}));
  Simulator simulator(std::move(scene), frugalBot(), quiet(), 1, {});
  std::vector<Contact> contacts;
  Eigen::Isometry3d world_from_cart = simulator.scene().models[2].world_from_model;
  for (int i = 0; i < 600; ++i) {
    world_from_cart.translation().x() += 0.3 * toSeconds(kPhysicsStep);
    simulator.moveModel(2, world_from_cart);
    for (const Contact& contact : simulator.step().contacts) contacts.push_back(contact);
  }
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].other, "cart");
  EXPECT_FALSE(contacts[0].driven_into);
  EXPECT_EQ(simulator.groundTruth().world_from_base.x_m, 0.0);
}

TEST(Simulator, ARobotThatDrivesIntoAMovingObstacleIsToBlame) {
  Scene scene = wallScene();
  scene.models.push_back(box(scene, "cart", {0.2, 0.2, 0.5}, {-1.0, 0, 0.25}));
  Simulator simulator(std::move(scene), frugalBot(), quiet(), 1, {});
  simulator.setCommand({-0.3, 0.0});
  std::vector<Contact> contacts;
  Eigen::Isometry3d world_from_cart = simulator.scene().models[2].world_from_model;
  for (int i = 0; i < 800; ++i) {
    world_from_cart.translation().x() -= 0.05 * toSeconds(kPhysicsStep);
    simulator.moveModel(2, world_from_cart);
    for (const Contact& contact : simulator.step().contacts) contacts.push_back(contact);
  }
  ASSERT_FALSE(contacts.empty());
  EXPECT_TRUE(contacts[0].driven_into);
}

TEST(Simulator, ARobotThatSomethingOverlapsMayDriveOutButNotIn) {
  Scene scene = wallScene();
  Simulator inward(scene, frugalBot(), quiet(), 1, {0.9, 0.0, 0.0});
  inward.setCommand({0.3, 0.0});
  EXPECT_EQ(run(inward, 1.0).size(), 1U);
  EXPECT_NEAR(inward.groundTruth().world_from_base.x_m, 0.9, 1e-9);
  inward.setCommand({-0.3, 0.0});
  run(inward, 1.0);
  EXPECT_LT(inward.groundTruth().world_from_base.x_m, 0.7);
}

TEST(Simulator, AStaleCommandStopsTheWheels) {
  SimulatorParams params = quiet();
  params.command_timeout_s = 0.5;
  Simulator simulator(wallScene(), frugalBot(), params, 1, {-5.0, 0.0, 0.0});
  simulator.setCommand({0.4, 0.0});
  run(simulator, 0.5);
  EXPECT_GT(simulator.groundTruth().twist.v_mps, 0.39);
  run(simulator, 1.0);  // a dozen time constants of the motor
  EXPECT_NEAR(simulator.groundTruth().twist.v_mps, 0.0, 1e-4);
}

TEST(Simulator, ACommandThatIsNoNumberIsRefusedAndStops) {
  Simulator simulator(wallScene(), frugalBot(), quiet(), 1, {-5.0, 0.0, 0.0});
  EXPECT_TRUE(simulator.setCommand({0.4, 0.0}));
  run(simulator, 0.5);
  EXPECT_FALSE(simulator.setCommand({std::nan(""), 0.0}));
  run(simulator, 1.0);
  EXPECT_NEAR(simulator.groundTruth().twist.v_mps, 0.0, 1e-4);
}

TEST(Simulator, SameSeedSameBytesAndAnotherSeedOthers) {
  const auto bytes = [](std::uint64_t seed) {
    Simulator simulator(wallScene(), frugalBot(), SimulatorParams{}, seed, {});
    simulator.setCommand({0.2, 0.4});
    return bytesOf(simulator, 2.0);
  };
  EXPECT_EQ(bytes(7), bytes(7));
  EXPECT_NE(bytes(7), bytes(8));
}

TEST(Simulator, SwitchingASensorOnLeavesTheOthersBytes) {
  SimulatorParams with = quiet();
  with.sensors.camera = true;
  with.sensors.rgbd = true;
  with.camera.width_px = with.rgbd.color.width_px = 64;
  with.camera.height_px = with.rgbd.color.height_px = 48;
  Simulator simulator_with(wallScene(), frugalBot(), with, 7, {});
  Simulator simulator_without(wallScene(), frugalBot(), quiet(), 7, {});
  EXPECT_EQ(bytesOf(simulator_with, 0.6), bytesOf(simulator_without, 0.6));
}

TEST(Simulator, CamerasGiveImagesAtTheInstantOfTheirStamp) {
  SimulatorParams params = quiet();
  params.sensors.camera = params.sensors.rgbd = true;
  params.camera.width_px = params.rgbd.color.width_px = 64;
  params.camera.height_px = params.rgbd.color.height_px = 48;
  params.camera.rate_hz = params.rgbd.color.rate_hz = 10.0;
  Simulator simulator(wallScene(), frugalBot(), params, 1, {-1.0, 0.0, 0.0});
  std::optional<CameraImage> image;
  std::optional<RgbdImages> rgbd;
  for (int i = 0; i < 20; ++i) {
    SimOutput output = simulator.step();
    if (output.image) image = output.image;
    if (output.rgbd) rgbd = output.rgbd;
  }
  ASSERT_TRUE(image && rgbd);
  EXPECT_EQ(image->stamp, stampFromSeconds(1.1));
  EXPECT_EQ(image->bgr.cols, 64);
  // The wall's face is 2 m ahead of base_link, the camera 0.12 m behind it: within the depth noise at 2.1 m.
  EXPECT_NEAR(rgbd->depth.depth_m.at<float>(24, 32), 2.12, 0.08);
}

TEST(Simulator, ResetPutsTheRobotStandingAtThePose) {
  Simulator simulator(wallScene(), frugalBot(), quiet(), 1, {});
  simulator.setCommand({0.4, 0.0});
  run(simulator, 1.0);
  simulator.reset({-2.0, 1.0, 0.5});
  run(simulator, 1.0);
  const GroundTruth truth = simulator.groundTruth();
  EXPECT_EQ(truth.world_from_base.x_m, -2.0);
  EXPECT_EQ(truth.world_from_base.yaw_rad, 0.5);
  EXPECT_EQ(truth.stamp, stampFromSeconds(3.0));
}

TEST(Simulator, AWalkingPersonIsSeenAndTouches) {
  Scene scene = wallScene();
  Person person;
  person.name = "walker";
  person.posture = Posture::kWalking;
  person.loop = false;
  person.waypoints = {{0.0, {-3.0, 0.0, 0.0}}, {6.0, {0.6, 0.0, 0.0}}};
  scene.people.push_back(person);
  Simulator simulator(std::move(scene), frugalBot(), quiet(), 1, {});
  float nearest_before = 100.0F, nearest_after = 100.0F;
  std::vector<Contact> contacts;
  for (int i = 0; i < 1200; ++i) {
    const SimOutput output = simulator.step();
    contacts.insert(contacts.end(), output.contacts.begin(), output.contacts.end());
    if (!output.scan) continue;
    for (const float range : output.scan->ranges_m) {
      float& nearest = i < 200 ? nearest_before : nearest_after;
      if (std::isfinite(range)) nearest = std::min(nearest, range);
    }
  }
  EXPECT_GT(nearest_before, 0.9F);
  EXPECT_LT(nearest_after, 0.4F);
  ASSERT_FALSE(contacts.empty());
  EXPECT_EQ(contacts[0].other, "walker");
  EXPECT_FALSE(contacts[0].driven_into);
}

TEST(Simulator, RefusesWhatItCannotBuild) {
  SimulatorParams params;
  params.imu.rate_hz = -5.0;
  EXPECT_THROW(Simulator(wallScene(), frugalBot(), params, 1, {}), ConfigError);
  EXPECT_THROW(Simulator(wallScene(), frugalBot(), {}, 1, {std::nan(""), 0, 0}), ConfigError);
  for (const char* link : {"imu_link", "laser", "camera_optical_frame"}) {
    SimulatorParams with_camera;
    with_camera.sensors.camera = true;
    RobotModel robot = frugalBot();
    robot.base_from_link.erase(link);
    EXPECT_THROW(Simulator(wallScene(), robot, with_camera, 1, {}), ConfigError) << link;
  }
}

}  // namespace
}  // namespace frugal_nav::sim
