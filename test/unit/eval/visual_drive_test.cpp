// Visual odometry on a rendered drive through worlds/lab.world.
#include <gtest/gtest.h>

#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::eval {
namespace {

const std::string kShare = FRUGAL_NAV_SOURCE_DIR;

/// Straight, a right turn on the spot, straight, in daylight at 320x240.
DriveRecording straightTurnStraight() {
  const sim::Scene scene = sim::loadWorld(kShare + "/worlds/lab.world", sim::ResourcePath()).scene;
  const RobotModel robot = loadRobot(kShare + "/urdf/frugal_bot.urdf");
  sim::SimulatorParams params;
  params.camera.width_px = 320;
  params.camera.height_px = 240;
  params.lighting.setting = "daylight";
  constexpr std::uint64_t kSeed = 500001;
  return recordDrive(scene, robot, params, kSeed, {-3.7, -2.4, M_PI_2}, {{4.3, -M_PI_2}, {3.4, 0.0}});
}

TEST(VisualDrive, DriftsLessThanTwoPercentInDaylight) {
  const DriveRecording recording = straightTurnStraight();
  ASSERT_EQ(recording.contacts, 0);
  const VisualDriveResult result = runVisualOdometry(recording, VisualOdometryParams());
  EXPECT_LT(result.final_error_m, 0.02 * recording.length_m);
  EXPECT_GT(result.tracked_share, 0.9);
  EXPECT_NEAR(result.outputs.back().status.scale, 1.0, 0.02);
  EXPECT_GT(result.cloud.size(), 100U);
}

}  // namespace
}  // namespace frugal_nav::eval
