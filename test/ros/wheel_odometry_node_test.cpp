#include "support/ros_test.hpp"

#include <cmath>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gmock/gmock.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <frugal_nav/WheelTicks.h>

namespace frugal_nav {
namespace {

using test::runProgram;
using test::waitUntil;
using testing::HasSubstr;

constexpr double kRadius_m = 0.033;  // of urdf/frugal_bot.urdf
constexpr int kTicksPerRevolution = 1440;

class WheelOdometryNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(test::waitForSubscriber(ticks_));
    ASSERT_TRUE(odom_.waitForPublisher());
    ASSERT_TRUE(joints_.waitForPublisher());
    // Each test begins at the starting pose: the node takes a stamp before the last for a jump of time.
    static double start_s = 10000.0;
    start_s -= 1000.0;
    stamp_ = ros::Time(start_s);
    ASSERT_NO_FATAL_FAILURE(send(left_, right_));
  }

  void send(std::int64_t left, std::int64_t right) {
    WheelTicks msg;
    msg.header.stamp = stamp_;
    msg.left = left;
    msg.right = right;
    const std::size_t before = odom_.messages.size();
    ticks_.publish(msg);
    ASSERT_TRUE(odom_.waitForCount(before + 1)) << "no odom for these ticks";
    ASSERT_EQ(odom_.messages.back().header.stamp, stamp_) << "the stamp of the input it came from";
    stamp_ += ros::Duration(0.02);
  }

  ros::NodeHandle nh_;
  ros::Publisher ticks_ = nh_.advertise<WheelTicks>("robot/wheel_ticks", 10);
  test::Recorder<nav_msgs::Odometry> odom_{nh_, "robot/odom"};
  test::Recorder<sensor_msgs::JointState> joints_{nh_, "robot/joint_states"};
  test::Recorder<tf2_msgs::TFMessage> tf_{nh_, "/tf"};
  ros::Time stamp_;
  std::int64_t left_ = 65500;  // 36 counts before a counter of 16 bits begins anew
  std::int64_t right_ = 65500;
};

TEST_F(WheelOdometryNodeTest, TicksBecomeOdomTfAndJointStates) {
  ASSERT_TRUE(tf_.waitForPublisher());
  for (int i = 1; i <= 10; ++i)
    ASSERT_NO_FATAL_FAILURE(send((left_ + 20 * i) & 0xffff, (right_ + 20 * i) & 0xffff));
  const double turned_rad = 200.0 / kTicksPerRevolution * 2.0 * M_PI;
  const nav_msgs::Odometry& odom = odom_.messages.back();
  EXPECT_EQ(odom.header.frame_id, "odom");
  EXPECT_EQ(odom.child_frame_id, "base_link");
  EXPECT_NEAR(odom.pose.pose.position.x, 1.0 + turned_rad * kRadius_m, 1e-9)
      << "start_x_m, and across the roll-over";
  EXPECT_NEAR(odom.pose.pose.position.y, 0.0, 1e-9);
  EXPECT_NEAR(odom.twist.twist.linear.x, turned_rad * kRadius_m / 0.2, 1e-6);
  EXPECT_GT(odom.pose.covariance[0], 0.0);
  EXPECT_GT(odom.pose.covariance[35], 0.0);
  EXPECT_GT(odom.pose.covariance[14], 0.0) << "what cannot move is certain, but not infinitely";

  ASSERT_TRUE(waitUntil([&] {
    return !tf_.messages.empty() && tf_.messages.back().transforms.front().header.stamp == odom.header.stamp;
  }));
  const geometry_msgs::TransformStamped& transform = tf_.messages.back().transforms.front();
  EXPECT_EQ(transform.header.frame_id, "odom");
  EXPECT_EQ(transform.child_frame_id, "base_link");
  EXPECT_EQ(transform.transform.translation.x, odom.pose.pose.position.x);

  ASSERT_TRUE(waitUntil([&] {
    return !joints_.messages.empty() && joints_.messages.back().header.stamp == odom.header.stamp;
  }));
  const sensor_msgs::JointState& last = joints_.messages.back();
  const sensor_msgs::JointState& first = joints_.messages[joints_.messages.size() - 11];
  EXPECT_EQ(last.name, (std::vector<std::string>{"wheel_left_joint", "wheel_right_joint"}));
  EXPECT_NEAR(last.position[0] - first.position[0], turned_rad, 1e-9);
  EXPECT_NEAR(last.position[1] - first.position[1], turned_rad, 1e-9);
}

TEST_F(WheelOdometryNodeTest, ATimeJumpStartsAtTheStartingPoseAgain) {
  for (int i = 1; i <= 5; ++i) ASSERT_NO_FATAL_FAILURE(send(left_ + 5 * i, right_ + 7 * i));
  EXPECT_GT(odom_.messages.back().pose.pose.position.x, 1.0);
  stamp_ -= ros::Duration(5.0);
  ASSERT_NO_FATAL_FAILURE(send(left_ + 100, right_ + 100));
  EXPECT_EQ(odom_.messages.back().pose.pose.position.x, 1.0);
  EXPECT_EQ(odom_.messages.back().pose.pose.orientation.w, 1.0);
}

TEST_F(WheelOdometryNodeTest, AStampThatComesTwiceGivesOneOdom) {
  ASSERT_NO_FATAL_FAILURE(send(left_ + 1, right_ + 1));
  stamp_ -= ros::Duration(0.02);
  const std::size_t before = odom_.messages.size();
  WheelTicks twice;
  twice.header.stamp = stamp_;
  twice.left = twice.right = left_ + 1;
  ticks_.publish(twice);
  stamp_ += ros::Duration(0.02);
  ASSERT_NO_FATAL_FAILURE(
      send(left_ + 2, right_ + 2));  // one queue: once this is answered, the one before has been too
  EXPECT_EQ(odom_.messages.size(), before + 1);
}

TEST_F(WheelOdometryNodeTest, ReportsItsInputsAsDiagnostics) {
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(nh_, "/diagnostics");
  test::TestClock clock(nh_, 50.0);
  ASSERT_TRUE(diagnostics.waitForPublisher());
  const auto reported = [&] {
    clock.advance(0.5);
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& value : status.values) {
          if (value.key == "wheel_ticks received" && value.value != "0") return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(waitUntil(reported));
}

TEST(WheelOdometryNode, JointStatesBecomeOdom) {
  ros::NodeHandle nh;
  ros::Publisher joints = nh.advertise<sensor_msgs::JointState>("by_angles/joint_states", 50);
  test::Recorder<nav_msgs::Odometry> odom(nh, "by_angles/odom");
  ASSERT_TRUE(test::waitForSubscriber(joints));
  ASSERT_TRUE(odom.waitForPublisher());
  sensor_msgs::JointState msg;
  for (int i = 0; i <= 10; ++i) {
    msg.header.stamp = ros::Time(10.0 + 0.02 * i);
    msg.name = {"arm", "wheel_right_joint", "wheel_left_joint"};
    msg.position = {9.0, 0.1 * i, 0.1 * i};
    if (i == 5) msg.position[1] = std::nan("");  // refused: the next one bridges the gap
    joints.publish(msg);
    msg.name = {"arm"};  // of another publisher
    msg.position = {9.0};
    joints.publish(msg);
  }
  ASSERT_TRUE(odom.waitForCount(10));
  EXPECT_EQ(odom.messages.back().header.frame_id, "odom_by_angles");
  EXPECT_NEAR(odom.messages.back().pose.pose.position.x, kRadius_m, 1e-9);
}

TEST(WheelOdometryNode, AMissingRobotDescriptionIsNamed) {
  const test::ProgramResult result = runProgram("wheel_odometry_node", "__ns:=nowhere");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("robot_description"));
}

TEST(WheelOdometryNode, AnUnknownParameterIsNamed) {
  const test::ProgramResult result =
      runProgram("wheel_odometry_node", "__ns:=robot __name:=unknown_key _ticks_per_revolutoin:=1000");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("ticks_per_revolutoin"));
  EXPECT_THAT(result.output, HasSubstr("did you mean \"ticks_per_revolution\""));
}

TEST(WheelOdometryNode, AParameterOfAWrongTypeIsNamed) {
  const test::ProgramResult result =
      runProgram("wheel_odometry_node", "__ns:=robot __name:=wrong_type _velocity_window_s:=long");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("velocity_window_s"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "wheel_odometry_node_test");
  const ros::NodeHandle keeps_ros_running;
  return RUN_ALL_TESTS();
}
