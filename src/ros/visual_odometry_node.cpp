#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/visual_messages.hpp>
#include <frugal_nav/ros/visual_odometry_node.hpp>

namespace frugal_nav {
namespace {

VisualOdometryNodeParams load(const ros::NodeHandle& pnh) {
  VisualOdometryNodeParams params;
  loadParameters(pnh, params);
  return params;
}

VisualCloud makeCloud(const VisualMapOutputParams& params) {
  return VisualCloud(params.voxel_m, static_cast<std::size_t>(params.max_points));
}

}  // namespace

VisualOdometryNode::VisualOdometryNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)), diagnostics_(nh, pnh), cloud_(makeCloud(params_.map_output)) {
  intake_ = std::make_unique<ImageIntake>(
      nh, params_.intake, diagnostics_,
      ImageIntake::Callbacks{[this](const CameraFrame& frame) { process(frame); }, [this] { forget(); }, {}});
  odom_pub_ = intake_->advertise<nav_msgs::Odometry>("vo/odom", 5);
  points_pub_ = intake_->advertise<sensor_msgs::PointCloud2>("vo/points", 5);
  status_pub_ = intake_->advertise<VoStatus>("vo/status", 5);
  obstacle_pub_ = intake_->advertise<Obstacle>("vo/obstacle", 5);
  map_pub_ = intake_->advertise<sensor_msgs::PointCloud2>("vo/map", 1);
  if (params_.publish_tf) intake_->stayAwake();
  if (params_.use_region) {
    diagnostics_.input("obstacle/nearest");
    nearest_sub_ = nh.subscribe("obstacle/nearest", 5, &VisualOdometryNode::onObstacle, this,
                                ros::TransportHints().tcpNoDelay());
  }
  live_ = tuneLive<VisualOdometryNodeParams>(pnh, params_, [this](const VisualOdometryNodeParams& wanted) {
    params_ = wanted;
    forget();
  });
}

void VisualOdometryNode::onObstacle(const Obstacle& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  intake_->checkStamp("obstacle/nearest", stamp);
  diagnostics_.input("obstacle/nearest").received(stamp, toStamp(ros::Time::now()));
  nearest_ = msg;
}

void VisualOdometryNode::process(const CameraFrame& frame) {
  if (!frame.fault.empty()) {
    publishFault(frame);
    return;
  }
  prepare(frame);
  VisualInput input;
  input.stamp = frame.stamp;
  input.image = frame.bgr;
  input.odom_from_base = toIsometry(frame.odometry.odom_from_base);
  input.region = region(frame);
  const ros::WallTime start = ros::WallTime::now();
  const VisualOdometryOutput output = odometry_->process(input);
  diagnostics_.set("time of an image [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  cloud_.add(output.retired);
  publish(frame, output);
  publishObstacle(frame, output, input.region);
  publishMap(frame.stamp);
  report(output.status);
  last_ = output;
}

void VisualOdometryNode::prepare(const CameraFrame& frame) {
  if (!odometry_) {
    odometry_.emplace(params_.odometry, frame.camera, frame.base_from_optical);
  } else if (camera_ != frame.camera) {
    odometry_->setCamera(frame.camera);
  }
  camera_ = frame.camera;
}

/// Where to look for more features: the nearest obstacle of an earlier, but not too old, image.
std::optional<cv::Rect> VisualOdometryNode::region(const CameraFrame& frame) const {
  if (!nearest_ || !nearest_->found) return std::nullopt;
  const double age_s = toSeconds(frame.stamp - toStamp(nearest_->header.stamp));
  if (age_s < 0.0 || age_s > params_.region_age_s) return std::nullopt;
  const auto& roi = nearest_->region;
  const cv::Rect wanted(static_cast<int>(roi.x_offset), static_cast<int>(roi.y_offset),
                        static_cast<int>(roi.width), static_cast<int>(roi.height));
  const cv::Rect inside = wanted & cv::Rect(0, 0, frame.bgr.cols, frame.bgr.rows);
  return inside.empty() ? std::nullopt : std::make_optional(inside);
}

void VisualOdometryNode::publish(const CameraFrame& frame, const VisualOdometryOutput& output) {
  const IntakeParams& frames = params_.intake.base;
  const Eigen::Isometry3d odom_from_camera =
      toIsometry(frame.odometry.odom_from_base) * frame.base_from_optical;
  const nav_msgs::Odometry odometry =
      toRos(output, last_ ? &*last_ : nullptr, frames.odom_frame, frames.base_frame);
  odom_pub_.publish(odometry);
  if (params_.publish_tf) broadcast(odometry);
  status_pub_.publish(toRos(output.status, output.stamp, frame.frame));
  points_pub_.publish(pointsMessage(output, odom_from_camera, frames.odom_frame));
}

void VisualOdometryNode::broadcast(const nav_msgs::Odometry& odometry) {
  geometry_msgs::TransformStamped transform;
  transform.header = odometry.header;
  transform.child_frame_id = odometry.child_frame_id;
  const geometry_msgs::Pose& pose = odometry.pose.pose;
  transform.transform.translation.x = pose.position.x;
  transform.transform.translation.y = pose.position.y;
  transform.transform.translation.z = pose.position.z;
  transform.transform.rotation = pose.orientation;
  broadcaster_.sendTransform(transform);
}

/// An image of no use still has its answer: no points, and the reason.
void VisualOdometryNode::publishFault(const CameraFrame& frame) {
  VisualOdometryOutput nothing;
  nothing.stamp = frame.stamp;
  nothing.status.state = VisualState::kLost;
  nothing.status.reason = VisualReason::kBadImage;
  VoStatus status = toRos(nothing.status, frame.stamp, frame.frame);
  status.reason = frame.fault;
  const std::string& odom_frame = params_.intake.base.odom_frame;
  status_pub_.publish(status);
  points_pub_.publish(pointsMessage(nothing, Eigen::Isometry3d::Identity(), odom_frame));
  VisualObstacleResult no_obstacle;
  no_obstacle.reason = frame.fault;
  obstacle_pub_.publish(toRos(no_obstacle, Eigen::Isometry3d::Identity(), {}, frame.stamp, odom_frame));
  diagnostics_.status(diagnostic_msgs::DiagnosticStatus::WARN, frame.fault);
}

void VisualOdometryNode::publishObstacle(const CameraFrame& frame, const VisualOdometryOutput& output,
                                         const std::optional<cv::Rect>& region) {
  if (obstacle_pub_.getNumSubscribers() == 0) return;
  VisualObstacleResult result;
  result.reason = "no region to look in";
  if (region) result = findNearestObstacle(output, *region, params_.obstacle);
  const Eigen::Isometry3d odom_from_visual =
      toIsometry(frame.odometry.odom_from_base) * output.odom_from_base.inverse();
  obstacle_pub_.publish(toRos(result, odom_from_visual, region.value_or(cv::Rect()), frame.stamp,
                              params_.intake.base.odom_frame));
}

void VisualOdometryNode::publishMap(Stamp stamp) {
  if (map_pub_.getNumSubscribers() == 0) return;
  const ros::Time now = toRos(stamp);
  if (!last_map_.isZero() && (now - last_map_).toSec() < params_.map_output.period_s) return;
  last_map_ = now;
  map_pub_.publish(cloudMessage(cloud_.points(), stamp, params_.intake.base.odom_frame));
}

void VisualOdometryNode::report(const VisualStatus& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::string words =
      std::string(text(status.state)) +
      (status.reason == VisualReason::kNone ? "" : std::string(": ") + text(status.reason));
  const bool is_lost = status.state == VisualState::kLost;
  diagnostics_.status(is_lost ? DiagnosticStatus::WARN : DiagnosticStatus::OK, words);
  diagnostics_.set("features", status.features);
  diagnostics_.set("inliers", status.inliers);
  diagnostics_.set("scale", status.scale);
  if (is_lost) ROS_WARN_THROTTLE(5.0, "%s; the pose follows the wheels", words.c_str());
}

/// Time jumped back, or other parameters: all begins anew with the next image.
void VisualOdometryNode::forget() {
  odometry_.reset();
  last_.reset();
  cloud_ = makeCloud(params_.map_output);
  nearest_.reset();
  last_map_ = ros::Time();
}

}  // namespace frugal_nav
