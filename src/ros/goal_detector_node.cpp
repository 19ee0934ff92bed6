#include <algorithm>
#include <cstdio>

#include <cv_bridge/cv_bridge.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <opencv2/imgproc.hpp>
#include <ros/package.h>
#include <sensor_msgs/image_encodings.h>

#include <frugal_nav/Detection2DArray.h>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/goal_detector_node.hpp>
#include <frugal_nav/ros/parameters.hpp>

namespace frugal_nav {
namespace {

GoalDetectorNodeParams load(const ros::NodeHandle& pnh) {
  GoalDetectorNodeParams params;
  loadParameters(pnh, params);
  return params;
}

GoalFinder makeFinder(const GoalDetectorNodeParams& params) {
  const std::string share_dir = ros::package::getPath("frugal_nav");
  const std::string config = configOf(params.detector, share_dir);
  return {makeDetector(readParamFile(config), params.detector, share_dir), params.head, params.tracker,
          params.feet, params.closer_look};
}

Detection2DArray detectionsMessage(const CameraFrame& frame, const std::vector<Detection>& detections) {
  Detection2DArray msg;
  msg.header = headerOf(frame);
  msg.image_width = static_cast<std::uint32_t>(frame.width_px);
  msg.image_height = static_cast<std::uint32_t>(frame.height_px);
  for (const Detection& detection : detections) {
    Detection2D box;
    box.class_id = detection.class_id;
    box.label = detection.label;
    box.score = detection.score;
    box.x = detection.box.x;
    box.y = detection.box.y;
    box.width = detection.box.width;
    box.height = detection.box.height;
    msg.detections.push_back(box);
  }
  return msg;
}

/// The goal's place; which way a person looks is not known.
/// While only its feet are seen, the height is that of an earlier image: its variance says so.
geometry_msgs::PoseWithCovarianceStamped observedMessage(const TrackedGoal& goal, bool is_seen,
                                                         const std::string& frame) {
  constexpr double kHeightVariance_m2 = 0.01;
  constexpr double kUnseenHeightVariance_m2 = 1.0;
  constexpr double kUnknownAngle_rad2 = M_PI * M_PI;
  geometry_msgs::PoseWithCovarianceStamped msg;
  msg.header.stamp = toRos(goal.stamp);
  msg.header.frame_id = frame;
  msg.pose.pose.position.x = goal.p_odom.x();
  msg.pose.pose.position.y = goal.p_odom.y();
  msg.pose.pose.position.z = goal.above_floor_m;
  msg.pose.pose.orientation.w = 1.0;
  auto& covariance = msg.pose.covariance;
  covariance[0] = goal.covariance_m2(0, 0);
  covariance[1] = covariance[6] = goal.covariance_m2(0, 1);
  covariance[7] = goal.covariance_m2(1, 1);
  covariance[14] = is_seen ? kHeightVariance_m2 : kUnseenHeightVariance_m2;
  covariance[21] = covariance[28] = covariance[35] = kUnknownAngle_rad2;
  return msg;
}

/// What a box says, for people.
std::string captionOf(const Detection& detection, const HeadSighting& sighting) {
  char text[64];
  if (sighting.status == HeadSighting::Status::kGood) {
    std::snprintf(text, sizeof(text), "%s %.2f  %.1f m", detection.label.c_str(), detection.score,
                  sighting.range_m);
  } else {
    std::snprintf(text, sizeof(text), "%s %.2f  %s", detection.label.c_str(), detection.score,
                  toText(sighting.status));
  }
  return text;
}

/// Under a box, or over it where there is no room, and always within the image.
void writeUnder(const cv::Rect2f& box, const std::string& text, const cv::Scalar& color, cv::Mat& image) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  const double size = std::max(0.4, image.cols / 1000.0);
  const cv::Size room = cv::getTextSize(text, kFont, size, 1, nullptr) + cv::Size(4, 4);
  const int below = static_cast<int>(box.br().y) + room.height;
  const int row = below < image.rows ? below : static_cast<int>(box.y) - 4;
  const cv::Point at(std::clamp(static_cast<int>(box.x), 2, std::max(2, image.cols - room.width)),
                     std::max(row, room.height));
  cv::putText(image, text, at, kFont, size, cv::Scalar::all(0), 3, cv::LINE_AA);
  cv::putText(image, text, at, kFont, size, color, 1, cv::LINE_AA);
}

cv::Mat drawn(const CameraFrame& frame, const GoalFrame& goal) {
  const cv::Scalar good(80, 220, 80);
  const cv::Scalar doubtful(60, 160, 240);
  cv::Mat image = frame.bgr.clone();
  for (std::size_t i = 0; i < goal.detections.size(); ++i) {
    const Detection& detection = goal.detections[i];
    const HeadSighting& sighting = goal.sightings[i];
    const cv::Scalar color = sighting.status == HeadSighting::Status::kGood ? good : doubtful;
    cv::rectangle(image, detection.box, color, 2);
    writeUnder(detection.box, captionOf(detection, sighting), color, image);
  }
  return image;
}

const char* toText(GoalTracker::State state) {
  switch (state) {
    case GoalTracker::State::kNone:
      return "no goal yet";
    case GoalTracker::State::kSeen:
      return "goal in view";
    case GoalTracker::State::kUnseen:
      return "goal out of view or missed; its place is kept";
    case GoalTracker::State::kLost:
      return "goal lost";
  }
  return "";
}

}  // namespace

GoalDetectorNode::GoalDetectorNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)), diagnostics_(nh, pnh), finder_(makeFinder(params_)) {
  intake_ = std::make_unique<ImageIntake>(
      nh, params_.intake, diagnostics_,
      ImageIntake::Callbacks{
          [this](const CameraFrame& frame) { process(frame); }, [this] { finder_.reset(); }, {}});
  detections_pub_ = intake_->advertise<Detection2DArray>("goal/detections", 5);
  observed_pub_ = intake_->advertise<geometry_msgs::PoseWithCovarianceStamped>("goal/observed", 5);
  debug_pub_ = intake_->advertise<sensor_msgs::Image>("goal/debug_image", 1);
  surfaces_sub_ = nh.subscribe<sensor_msgs::LaserScan>(
      "depth/scan", 5, [this](const sensor_msgs::LaserScanConstPtr& msg) {
        const LaserScan scan = fromRos(*msg);
        if (msg->header.frame_id == params_.intake.base.base_frame && !findFault(scan))
          finder_.addSurfaces(scan);
      });
  live_ = tuneLive<GoalDetectorNodeParams>(pnh, params_, [this](const GoalDetectorNodeParams& wanted) {
    params_.head = wanted.head;
    params_.tracker = wanted.tracker;
    params_.feet = wanted.feet;
    params_.closer_look = wanted.closer_look;
    finder_.setParams(params_.head, params_.tracker, params_.feet, params_.closer_look);
  });
}

void GoalDetectorNode::process(const CameraFrame& frame) {
  GoalView view;  // of a frame with a fault: without a picture, so that the goal's time runs on
  view.stamp = frame.stamp;
  if (frame.fault.empty()) {
    view.bgr = frame.bgr;
    view.camera = frame.camera;
    view.base_from_optical = frame.base_from_optical;
    view.odom_from_base = frame.odometry.odom_from_base;
  }
  const ros::WallTime start = ros::WallTime::now();
  GoalFrame goal = finder_.look(view);
  if (frame.fault.empty()) {
    diagnostics_.set("time of an image [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  } else {
    goal.fault = frame.fault;
  }
  publish(frame, goal);
  report(goal);
}

void GoalDetectorNode::publish(const CameraFrame& frame, const GoalFrame& goal) {
  detections_pub_.publish(detectionsMessage(frame, goal.detections));
  if (goal.observed) {
    const bool is_seen = goal.state == GoalTracker::State::kSeen;
    observed_pub_.publish(observedMessage(*goal.goal, is_seen, params_.intake.base.odom_frame));
  }
  if (debug_pub_.getNumSubscribers() > 0 && !frame.bgr.empty()) publishDebugImage(frame, goal);
}

void GoalDetectorNode::publishDebugImage(const CameraFrame& frame, const GoalFrame& goal) {
  debug_pub_.publish(
      cv_bridge::CvImage(headerOf(frame), sensor_msgs::image_encodings::BGR8, drawn(frame, goal))
          .toImageMsg());
}

void GoalDetectorNode::report(const GoalFrame& goal) {
  using diagnostic_msgs::DiagnosticStatus;
  const DetectorCounts& counts = finder_.detector().counts();
  diagnostics_.set("detections", static_cast<double>(goal.detections.size()));
  diagnostics_.set("boxes that were no numbers", static_cast<double>(counts.not_finite));
  if (!goal.fault.empty()) {
    diagnostics_.status(DiagnosticStatus::WARN, goal.fault);
    ROS_WARN_THROTTLE(5.0, "no detection: %s", goal.fault.c_str());
    return;
  }
  const bool is_lost = goal.state == GoalTracker::State::kLost;
  diagnostics_.status(is_lost ? DiagnosticStatus::WARN : DiagnosticStatus::OK, toText(goal.state));
  if (is_lost) ROS_WARN_THROTTLE(10.0, "goal lost");
}

}  // namespace frugal_nav
