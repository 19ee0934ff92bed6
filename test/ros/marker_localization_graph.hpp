#pragma once

#include "../unit/perception/marker_view.hpp"
#include "camera_graph.hpp"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/SetBool.h>
#include <tf2_msgs/TFMessage.h>

#include <frugal_nav/MarkerObservationArray.h>
#include <frugal_nav/ros/marker_localization_node.hpp>

namespace frugal_nav::test {

using PoseMessage = geometry_msgs::PoseWithCovarianceStamped;

const std::string kWallMap = std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/marker_wall.yaml";
const Pose2 kMapFromOdom{1.6, 0.2, 0.1};

/// A robot before the wall of test/data/marker_wall.yaml, its odometry at 20 Hz with an IMU beside it. The
/// node runs in this process, anew for each test.
class MarkerLocalizationGraph : public testing::Test {
 protected:
  static int count() {
    static int tests = 0;
    return ++tests;
  }
  void start() {
    pnh_.setParam("marker_map", kWallMap);
    node_ = std::make_unique<MarkerLocalizationNode>(graph_.nh, pnh_);
    ASSERT_TRUE(graph_.connect() && waitForSubscriber(imu_pub_));
    ASSERT_TRUE(observations_.waitForPublisher() && poses_.waitForPublisher() && tf_.waitForPublisher());
    graph_.publish(graph_.info());
  }
  /// Odometry and IMU of the present time, and their answer.
  void tick(double yaw_rate_radps = 0.0) {
    graph_.clock.advance(0.05);
    sensor_msgs::Imu imu;
    imu.header.stamp = graph_.clock.now();
    imu.header.frame_id = "base_link";
    imu.angular_velocity.z = yaw_rate_radps;
    if (no_gyro_) imu.angular_velocity_covariance[0] = -1.0;
    imu_pub_.publish(imu);
    graph_.publishOdometry();
  }
  void drive(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      tick();
      waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }, 0.02);
    }
  }
  sensor_msgs::Image picture(const MarkerMap& map = wallMap()) {
    const Pinhole camera = fromRos(graph_.info()).camera;
    const Eigen::Isometry3d map_from_camera = toIsometry(kMapFromOdom * graph_.pose) * CameraGraph::mount();
    return graph_.imageOf(viewOf(map, camera, map_from_camera, MarkerLight{}, random_), "mono8");
  }
  const MarkerObservationArray* show(const sensor_msgs::Image& image) {
    graph_.publish(image);
    return answerAt(observations_, image.header.stamp);
  }
  const PoseMessage* poseAt(ros::Time stamp) const {
    for (const PoseMessage& pose : poses_.messages) {
      if (pose.header.stamp == stamp) return &pose;
    }
    return nullptr;
  }
  /// A fix of the present time and a pose after it.
  void localize() {
    tick();
    const MarkerObservationArray* seen = show(picture());
    ASSERT_NE(seen, nullptr);
    ASSERT_TRUE(seen->accepted) << seen->reason;
    tick();
    ASSERT_TRUE(waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
    ASSERT_TRUE(waitForTransform());
  }
  /// That of the present time, which comes on another connection than its pose.
  bool waitForTransform() {
    return waitUntil([this] {
      return !tf_.messages.empty() && tf_.messages.back().transforms.at(0).header.stamp == graph_.clock.now();
    });
  }
  /// A fit over markers of 20 px with 0.2 px of noise in the corners errs by some centimetres.
  void expectAtTruth(const geometry_msgs::Pose& pose) const {
    const Pose2 truth = kMapFromOdom * graph_.pose;
    EXPECT_LT(distance(*planar(pose), truth), 0.05);
    EXPECT_NEAR(angleBetween(planar(pose)->yaw_rad, truth.yaw_rad), 0.0, 0.03);
  }
  bool call(const std::string& name, bool on) {
    std_srvs::SetBool::Request request;
    std_srvs::SetBool::Response response;
    request.data = on ? 1 : 0;
    return callInBackground([&] { return ros::service::call(pnh_.resolveName(name), request, response); }) &&
           response.success != 0;
  }
  /// Calls a service of this process, whose callbacks are served here.
  static bool callInBackground(const std::function<bool()>& call) {
    std::atomic<bool> done{false};
    bool good = false;
    std::thread caller([&] {
      good = call();
      done = true;
    });
    waitUntil([&] { return done.load(); });
    caller.join();
    return good;
  }
  std::string status() {
    std::string text;
    for (const auto& message : diagnostics_.messages) {
      for (const auto& entry : message.status) text = entry.message;
    }
    return text;
  }

  /// Whether a value of the diagnostics comes to hold a text.
  bool waitForValue(const std::string& key, const std::string& text) {
    diagnostics_.messages.clear();
    return waitUntil([&] {
      graph_.clock.advance(0.1);
      for (const auto& message : diagnostics_.messages) {
        for (const auto& value : message.status.at(0).values) {
          if (value.key.rfind(key, 0) == 0 && value.value.find(text) != std::string::npos) return true;
        }
      }
      return false;
    });
  }
  /// Sound odometry, IMU and image are taken as ever.
  void expectGoesOn() {
    tick();
    EXPECT_TRUE(waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
    const MarkerObservationArray* seen = show(picture());
    ASSERT_NE(seen, nullptr);
    EXPECT_TRUE(seen->accepted) << seen->reason;
    tick();
    ASSERT_TRUE(waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
    expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
  }

  const std::string name_ = "t" + std::to_string(count());
  CameraGraph graph_{name_};
  ros::NodeHandle pnh_{"~" + name_};
  ros::Publisher imu_pub_ = graph_.nh.advertise<sensor_msgs::Imu>("imu/data_raw", 10);
  Recorder<MarkerObservationArray> observations_{graph_.nh, "markers"};
  Recorder<PoseMessage> poses_{graph_.nh, "pose"};
  Recorder<tf2_msgs::TFMessage> tf_{graph_.nh, "/tf"};
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{graph_.nh, "/diagnostics"};
  Random random_{500005};
  bool no_gyro_ = false;
  std::unique_ptr<MarkerLocalizationNode> node_;
};

}  // namespace frugal_nav::test
