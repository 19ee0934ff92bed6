#include "support/ros_test.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/MarkerObservationArray.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/mission/waypoint_list.hpp>
#include <frugal_nav/ros/conversions.hpp>

// The node graph of marker.launch drives a tour of the map through worlds/marker_hall.world, in lock-step
// with the simulator: ticks, IMU, images and scans in, wheel speeds out.
namespace frugal_nav {
namespace {

using test::waitUntil;

constexpr double kGoalRadius_m = 0.30;
constexpr double kLongestWait_s = 200.0;  // of wall time

class DriveMarkersTest : public testing::Test {
 protected:
  void onState(const MissionState& msg) {
    if (msg.state != MissionState::STATE_REACHED || msg.goal_number <= reached_) {
      failed_ = failed_ || msg.state == MissionState::STATE_ABORTED;
      reason_ = msg.reason;
      return;
    }
    reached_ = msg.goal_number;
    const Eigen::Vector2d& waypoint = tour_.waypoints.at(reached_ - 1).position;
    EXPECT_LE((truth_.rbegin()->second.position() - waypoint).norm(), kGoalRadius_m)
        << "waypoint " << reached_;
  }
  void onContact(const Contact& msg) { ADD_FAILURE() << msg.link << " touched " << msg.other; }
  /// The errors of all poses whose instant the truth knows: position [m] and heading [rad].
  std::pair<double, double> rmse() const {
    double position = 0.0;
    double yaw = 0.0;
    double count = 0.0;
    for (const auto& [stamp, pose] : poses_) {
      const auto truth = truth_.find(stamp);
      if (truth == truth_.end()) continue;
      position += std::pow(distance(pose, truth->second), 2);
      yaw += std::pow(angleBetween(pose.yaw_rad, truth->second.yaw_rad), 2);
      ++count;
    }
    EXPECT_GT(count, 300.0);
    return {std::sqrt(position / count), std::sqrt(yaw / count)};
  }

  const WaypointList tour_ =
      readWaypoints(std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/marker_hall_tour.yaml");
  ros::NodeHandle nh_;
  std::map<Stamp, Pose2> truth_;  ///< the world is the map
  std::map<Stamp, Pose2> poses_;
  std::size_t reached_ = 0;
  bool failed_ = false;
  std::string reason_ = "no mission/state";
  std::size_t images_ = 0;
  std::size_t images_accepted_ = 0;
  ros::Subscriber truth_sub_ = nh_.subscribe<nav_msgs::Odometry>(
      "ground_truth/odom", 1000, [this](const nav_msgs::OdometryConstPtr& msg) {
        truth_[toStamp(msg->header.stamp)] = planar(msg->pose.pose).value();
      });
  ros::Subscriber pose_sub_ = nh_.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
      "pose", 1000, [this](const geometry_msgs::PoseWithCovarianceStampedConstPtr& msg) {
        const bool is_new = poses_.emplace(toStamp(msg->header.stamp), planar(msg->pose.pose).value()).second;
        EXPECT_TRUE(is_new) << "a stamp twice";
      });
  ros::Subscriber contact_sub_ =
      nh_.subscribe("ground_truth/contact", 100, &DriveMarkersTest::onContact, this);
  ros::Subscriber markers_sub_ = nh_.subscribe<MarkerObservationArray>(
      "markers", 100, [this](const MarkerObservationArrayConstPtr& msg) {
        ++images_;
        images_accepted_ += msg->accepted ? 1 : 0;
      });
  ros::Subscriber state_sub_ = nh_.subscribe("mission/state", 1000, &DriveMarkersTest::onState, this);
};

TEST_F(DriveMarkersTest, ReachesTheWaypointsOfTheMap) {
  ASSERT_TRUE(waitUntil([this] { return reached_ == tour_.waypoints.size() || failed_; }, kLongestWait_s))
      << reached_ << " waypoints reached; " << reason_;
  EXPECT_EQ(reached_, tour_.waypoints.size()) << reason_;
  const auto [position_m, yaw_rad] = rmse();
  // Twice what evaluate markers measures over many drives with a marker in view: one drive is one sample.
  EXPECT_LT(position_m, 0.06);
  EXPECT_LT(yaw_rad, 1.0 * M_PI / 180.0);
  EXPECT_GT(2 * images_accepted_, images_);
  std::printf("%.3f m, %.2f deg; %zu of %zu images used\n", position_m, yaw_rad * 180.0 / M_PI,
              images_accepted_, images_);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "drive_markers_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
