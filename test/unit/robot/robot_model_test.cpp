#include <clocale>

#include <gtest/gtest.h>

#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav {
namespace {

constexpr double kDegree = M_PI / 180.0;
// The URDF writes pi with 12 digits.
constexpr double kAngleDigits = 1e-9;

RobotModel frugalBot() { return loadRobot(FRUGAL_NAV_SOURCE_DIR "/urdf/frugal_bot.urdf"); }

std::string wheel(const std::string& side, double y) {
  return "<link name='" + side +
         "_wheel'><collision><origin rpy='1.57079632679 0 0'/><geometry><cylinder radius='0.1' "
         "length='0.02'/>"
         "</geometry></collision></link><joint name='" +
         side + "_joint' type='continuous'><parent link='base_link'/><child link='" + side +
         "_wheel'/><origin xyz='0 " + std::to_string(y) + " 0.1'/><axis xyz='0 1 0'/></joint>";
}

std::string robot(const std::string& parts) {
  return "<robot name='r'><link name='base_link'><collision><geometry><box size='0.4 0.3 0.1'/></geometry>"
         "</collision></link>" +
         parts + "</robot>";
}

std::string refusal(const std::string& urdf) {
  try {
    parseRobot(urdf, "test.urdf");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(FrugalBot, IsAQuarterOfAMetreWide) {
  const RobotModel model = frugalBot();
  EXPECT_EQ(model.name, "frugal_bot");
  EXPECT_NEAR(model.halfWidth_m(), 0.125, 1e-9);
  EXPECT_NEAR(model.circumradius_m(), std::hypot(0.16, 0.125), 1e-9);  // a rear corner
  EXPECT_NEAR(model.inradius_m(), 0.12, 1e-9);                         // the front edge
  EXPECT_NEAR(model.mass_kg, 2.5, 1e-9);
  EXPECT_GT(model.yaw_inertia_kgm2, 0.01);
  EXPECT_LT(model.yaw_inertia_kgm2, 0.05);
}

TEST(FrugalBot, HasTwoWheelsOnTheFloor) {
  const RobotModel model = frugalBot();
  EXPECT_EQ(model.drive.left_joint, "wheel_left_joint");
  EXPECT_EQ(model.drive.right_joint, "wheel_right_joint");
  EXPECT_NEAR(model.drive.separation_m, 0.21, 1e-9);
  EXPECT_NEAR(model.drive.radius_m, 0.033, 1e-9);
  EXPECT_NEAR(model.baseFrom("wheel_left_link").translation().z(), model.drive.radius_m, 1e-9);
  EXPECT_GT(model.baseFrom("wheel_left_link").translation().y(), 0.0);
}

TEST(FrugalBot, LooksFiveDegreesUpFromFortyCentimetres) {
  const RobotModel model = frugalBot();
  const Eigen::Isometry3d& base_from_optical = model.baseFrom("camera_optical_frame");
  EXPECT_NEAR(base_from_optical.translation().z(), 0.40, 1e-9);
  const Eigen::Vector3d ahead = base_from_optical.linear().col(2);
  EXPECT_NEAR(std::atan2(ahead.z(), ahead.x()), 5.0 * kDegree, kAngleDigits);
  EXPECT_NEAR(ahead.y(), 0.0, kAngleDigits);
  EXPECT_NEAR(base_from_optical.linear().col(0).y(), -1.0, kAngleDigits);  // x of the image to the right
  EXPECT_LT(base_from_optical.linear().col(1).z(), -0.99);                 // y of the image down
}

TEST(FrugalBot, ScansLevelWithNothingAroundTheLaserButTheMast) {
  const RobotModel model = frugalBot();
  const Eigen::Isometry3d& base_from_laser = model.baseFrom("laser");
  EXPECT_NEAR(base_from_laser.translation().z(), 0.18, 1e-9);
  EXPECT_LT((base_from_laser.linear() - Eigen::Matrix3d::Identity()).norm(), kAngleDigits);
  EXPECT_NEAR(model.planarBaseFrom("laser").yaw_rad, 0.0, kAngleDigits);
  for (const RobotShape& shape : model.collisions) {
    if (shape.link == "laser" || shape.link == "mast_link") continue;
    const auto* box = std::get_if<BoxShape>(&shape.geometry);
    const double half = box != nullptr ? 0.5 * box->size_m.z() : 0.033;
    const double z = shape.base_from_shape.translation().z();
    EXPECT_TRUE(z + half < 0.17 || z - half > 0.19) << shape.link;
  }
}

TEST(FrugalBot, NamesALinkItLacks) {
  try {
    frugalBot().baseFrom("gripper");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("gripper"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("frugal_bot"), std::string::npos);
  }
}

TEST(RobotModel, ReadsASmallRobot) {
  const RobotModel model = parseRobot(robot(wheel("left", 0.2) + wheel("right", -0.2)), "test.urdf");
  EXPECT_NEAR(model.drive.separation_m, 0.4, 1e-9);
  EXPECT_NEAR(model.drive.radius_m, 0.1, 1e-9);
  EXPECT_NEAR(model.halfWidth_m(), 0.21, 1e-6);  // the wheels stand out
}

TEST(RobotModel, BaseLinkMayHangBelowAFootprint) {
  const std::string urdf =
      robot(wheel("left", 0.2) + wheel("right", -0.2) +
            "<link name='base_footprint'/><joint name='f' type='fixed'><parent "
            "link='base_footprint'/><child link='base_link'/><origin xyz='0 0 0.05'/></joint>");
  const RobotModel model = parseRobot(urdf, "test.urdf");
  EXPECT_NEAR(model.baseFrom("base_footprint").translation().z(), -0.05, 1e-9);
  EXPECT_NEAR(model.baseFrom("left_wheel").translation().z(), 0.1, 1e-9);
}

TEST(RobotModel, IsPosedInTheFrameItIsAskedFor) {
  const std::string urdf =
      robot(wheel("left", 0.2) + wheel("right", -0.2) +
            "<link name='chassis'/><joint name='c' type='fixed'><parent link='base_link'/><child "
            "link='chassis'/><origin xyz='0.05 0 0'/></joint>");
  const RobotModel model = parseRobot(urdf, "test.urdf", "chassis");
  EXPECT_NEAR(model.baseFrom("base_link").translation().x(), -0.05, 1e-9);
}

TEST(RobotModel, RefusesABrokenUrdf) {
  EXPECT_NE(refusal("<robot name='r'><link").find("test.urdf"), std::string::npos);
  EXPECT_NE(refusal("").find("test.urdf"), std::string::npos);
  EXPECT_NE(refusal("<sdf/>").find("test.urdf"), std::string::npos);
}

TEST(RobotModel, RefusesARobotWithoutWheels) {
  EXPECT_NE(refusal(robot("")).find("wheels"), std::string::npos);
  EXPECT_NE(refusal(robot(wheel("left", 0.2))).find("wheels"), std::string::npos);
}

TEST(RobotModel, RefusesARobotWithoutBaseLink) {
  EXPECT_NE(refusal("<robot name='r'><link name='body'/></robot>").find("base_link"), std::string::npos);
}

TEST(RobotModel, RefusesTwoWheelsOnOneSide) {
  const std::string wheels = wheel("left", 0.2) + wheel("right", -0.2) + wheel("rear_left", 0.2);
  const std::string why = refusal(robot(wheels));
  EXPECT_NE(why.find("\"left_joint\""), std::string::npos) << why;
  EXPECT_NE(why.find("\"rear_left_joint\""), std::string::npos) << why;
}

TEST(RobotModel, RefusesAMeshThatTellsNoFootprint) {
  const std::string body =
      "<link name='body'><collision><geometry><mesh "
      "filename='package://r/body.stl'/></geometry></collision></link>"
      "<joint name='body_joint' type='fixed'><parent link='base_link'/><child link='body'/></joint>";
  const std::string why = refusal(robot(body + wheel("left", 0.2) + wheel("right", -0.2)));
  EXPECT_NE(why.find("link \"body\": its collision is a mesh"), std::string::npos) << why;
}

TEST(RobotModel, RefusesBothWheelsAtOnePlace) {
  EXPECT_NE(refusal(robot(wheel("left", 0.0) + wheel("right", 0.0))).find("same place"), std::string::npos);
}

TEST(RobotModel, NamesAMissingFile) { EXPECT_THROW(loadRobot("/no/such/robot.urdf"), ConfigError); }

TEST(RobotModel, ReadsDecimalPointsInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* set = std::setlocale(LC_ALL, "de_DE.UTF-8");
  if (set == nullptr) set = std::setlocale(LC_ALL, "de_DE");
  if (set == nullptr) GTEST_SKIP() << "no locale with a decimal comma is installed";
  const double radius = frugalBot().drive.radius_m;
  std::setlocale(LC_ALL, before.c_str());
  EXPECT_NEAR(radius, 0.033, 1e-9);
}

}  // namespace
}  // namespace frugal_nav
