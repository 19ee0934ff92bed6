#include <cmath>
#include <limits>

#include <cv_bridge/cv_bridge.h>
#include <opencv2/imgproc.hpp>
#include <ros/package.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/image_encodings.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <frugal_nav/Gap.h>
#include <frugal_nav/Obstacle.h>
#include <frugal_nav/perception/depth_choice.hpp>
#include <frugal_nav/perception/depth_picture.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/depth_gap_node.hpp>
#include <frugal_nav/ros/parameters.hpp>

namespace frugal_nav {
namespace {

namespace encodings = sensor_msgs::image_encodings;
const char* const kPoints = "vo/points";
const char* const kGoal = "goal/observed";

DepthGapNodeParams load(const ros::NodeHandle& pnh) {
  DepthGapNodeParams params;
  loadParameters(pnh, params);
  return params;
}

/// The fields that vo/points must have, all float32.
bool hasFields(const sensor_msgs::PointCloud2& msg) {
  for (const char* name : {"x", "y", "z", "u", "v", "sigma"}) {
    bool found = false;
    for (const sensor_msgs::PointField& field : msg.fields)
      found = found || (field.name == name && field.datatype == sensor_msgs::PointField::FLOAT32);
    if (!found) return false;
  }
  const std::size_t wanted = static_cast<std::size_t>(msg.width) * msg.height * msg.point_step;
  return msg.data.size() >= wanted;
}

std::vector<MetricPoint> pointsOf(const sensor_msgs::PointCloud2& msg) {
  using Iterator = sensor_msgs::PointCloud2ConstIterator<float>;
  std::vector<MetricPoint> points;
  Iterator x(msg, "x"), y(msg, "y"), z(msg, "z"), u(msg, "u"), v(msg, "v"), sigma(msg, "sigma");
  for (; x != x.end(); ++x, ++y, ++z, ++u, ++v, ++sigma) {
    MetricPoint point;
    point.pixel = cv::Point2f(*u, *v);
    point.p_odom = Eigen::Vector3f(*x, *y, *z).cast<double>();
    point.sigma_m = static_cast<double>(*sigma);
    if (point.p_odom.allFinite() && std::isfinite(*u) && std::isfinite(*v) && std::isfinite(*sigma))
      points.push_back(point);
  }
  return points;
}

std::string fitText(const MetricFit& fit) {
  if (!fit.known) return "not known yet";
  char text[96];
  std::snprintf(text, sizeof(text), "1/d = %.3g z %+.3g; %d points, %d floor, %d goal", fit.a, fit.b,
                fit.vo_points, fit.floor_points, fit.goal_points);
  return text;
}

}  // namespace

DepthGapNode::DepthGapNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)),
      diagnostics_(nh, pnh),
      depth_gap_(makeDepthNetwork(params_.network, ros::package::getPath("frugal_nav")), params_.depth) {
  intake_ = std::make_unique<ImageIntake>(
      nh, params_.intake, diagnostics_,
      ImageIntake::Callbacks{[this](const CameraFrame& frame) { process(frame); }, [this] { forget(); },
                             [this](const CameraFrame& frame) { return hasPoints(frame); }});
  inverse_pub_ = intake_->advertise<sensor_msgs::Image>("depth/inverse", 1);
  depth_pub_ = intake_->advertise<sensor_msgs::Image>("depth/image", 1);
  gap_pub_ = intake_->advertise<Gap>("gap", 5);
  obstacle_pub_ = intake_->advertise<Obstacle>("obstacle/nearest", 5);
  scan_pub_ = intake_->advertise<sensor_msgs::LaserScan>("depth/scan", 5);
  debug_pub_ = intake_->advertise<sensor_msgs::Image>("depth/debug_image", 1);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  if (params_.use_vo) {
    diagnostics_.input(kPoints);
    points_sub_ = nh.subscribe(kPoints, 5, &DepthGapNode::onPoints, this, hints);
  }
  diagnostics_.input(kGoal);
  goal_sub_ = nh.subscribe(kGoal, 5, &DepthGapNode::onGoal, this, hints);
  live_ = tuneLive<DepthGapNodeParams>(pnh, params_, [this](const DepthGapNodeParams& wanted) {
    params_.depth = wanted.depth;
    params_.vo_wait_s = wanted.vo_wait_s;
    params_.goal_memory_s = wanted.goal_memory_s;
    depth_gap_.setParams(params_.depth);
  });
}

void DepthGapNode::onPoints(const sensor_msgs::PointCloud2& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  intake_->checkStamp(kPoints, stamp);
  if (msg.header.frame_id != params_.intake.base.odom_frame || !hasFields(msg)) {
    diagnostics_.input(kPoints).refused("not points x, y, z, u, v, sigma in " +
                                        params_.intake.base.odom_frame);
    return;
  }
  diagnostics_.input(kPoints).received(stamp, toStamp(ros::Time::now()));
  points_ = Points{stamp, pointsOf(msg)};
  intake_->process();
}

void DepthGapNode::onGoal(const geometry_msgs::PoseWithCovarianceStamped& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  intake_->checkStamp(kGoal, stamp);
  KnownGoal goal;
  goal.p_odom = {msg.pose.pose.position.x, msg.pose.pose.position.y};
  goal.above_floor_m = msg.pose.pose.position.z;
  const auto& covariance = msg.pose.covariance;
  goal.covariance_m2 << covariance[0], covariance[1], covariance[6], covariance[7];
  if (msg.header.frame_id != params_.intake.base.odom_frame || !goal.p_odom.allFinite() ||
      !std::isfinite(goal.above_floor_m) || !goal.covariance_m2.allFinite()) {
    diagnostics_.input(kGoal).refused("not a finite place in " + params_.intake.base.odom_frame);
    return;
  }
  diagnostics_.input(kGoal).received(stamp, toStamp(ros::Time::now()));
  constexpr double kSeenHeightVariance_m2 = 0.1;  // above it the head was not in this image
  goal.seen = covariance[14] < kSeenHeightVariance_m2;
  goal_ = Goal{stamp, goal};
}

/// Whether an image need not wait for points any longer.
bool DepthGapNode::hasPoints(const CameraFrame& frame) const {
  if (!params_.use_vo || points_sub_.getNumPublishers() == 0) return true;
  if (points_ && points_->stamp >= frame.stamp) return true;
  return intake_->hasNewer() || intake_->waited_s() > params_.vo_wait_s;
}

std::optional<KnownGoal> DepthGapNode::goalAt(Stamp stamp) const {
  if (!goal_ || std::abs(toSeconds(stamp - goal_->stamp)) > params_.goal_memory_s) return std::nullopt;
  KnownGoal goal = goal_->goal;
  goal.seen = goal.seen && goal_->stamp == stamp;
  return goal;
}

DepthView DepthGapNode::viewOf(const CameraFrame& frame) {
  DepthView view;
  view.stamp = frame.stamp;
  if (!frame.fault.empty()) return view;
  view.bgr = frame.bgr;
  view.camera = frame.camera;
  view.base_from_optical = frame.base_from_optical;
  view.odom_from_base = frame.odometry.odom_from_base;
  if (points_ && points_->stamp == frame.stamp) view.points = points_->points;
  view.goal = goalAt(frame.stamp);
  return view;
}

void DepthGapNode::process(const CameraFrame& frame) {
  const ros::WallTime start = ros::WallTime::now();
  DepthFrame depth = depth_gap_.look(viewOf(frame));
  if (frame.fault.empty()) {
    diagnostics_.set("time of an image [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  } else {
    depth.fault = depth.gap.reason = depth.obstacle.reason = frame.fault;
  }
  publish(frame, depth);
  report(depth);
}

void DepthGapNode::publish(const CameraFrame& frame, const DepthFrame& depth) {
  const IntakeParams& frames = params_.intake.base;
  scan_pub_.publish(toRos(depth.scan, frames.base_frame));
  obstacle_pub_.publish(toRos(depth.obstacle, frames.odom_frame));
  gap_pub_.publish(toRos(depth.gap, frames.odom_frame));
  const auto publishImage = [&](ros::Publisher& publisher, const std::string& encoding,
                                const cv::Mat& image) {
    publisher.publish(cv_bridge::CvImage(headerOf(frame), encoding, image).toImageMsg());
  };
  const cv::Size size = frame.bgr.size();
  if (!depth.inverse.empty() && inverse_pub_.getNumSubscribers() > 0) {
    cv::Mat inverse;
    cv::resize(depth.inverse, inverse, size, 0.0, 0.0, cv::INTER_LINEAR);
    publishImage(inverse_pub_, encodings::TYPE_32FC1, inverse);
  }
  if (!depth.depth_m.empty() && depth_pub_.getNumSubscribers() > 0) {
    cv::Mat metres;
    cv::resize(depth.depth_m, metres, size, 0.0, 0.0, cv::INTER_NEAREST);  // no depths between two surfaces
    publishImage(depth_pub_, encodings::TYPE_32FC1, metres);
  }
  if (!frame.bgr.empty() && debug_pub_.getNumSubscribers() > 0)
    publishImage(debug_pub_, encodings::BGR8, drawDepthFrame(frame.bgr, depth));
}

void DepthGapNode::report(const DepthFrame& depth) {
  using diagnostic_msgs::DiagnosticStatus;
  diagnostics_.set("scale", fitText(depth.fit));
  diagnostics_.set("nearest obstacle [m]", depth.obstacle.distance_m);
  if (!depth.fault.empty()) {
    diagnostics_.status(DiagnosticStatus::WARN, depth.fault);
    ROS_WARN_THROTTLE(5.0, "no depth: %s", depth.fault.c_str());
    return;
  }
  const bool is_metric = depth.fit.known;
  diagnostics_.status(is_metric ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                      is_metric ? "running" : "no metric scale is known yet");
}

/// Time jumped back: all begins anew with the next image.
void DepthGapNode::forget() {
  depth_gap_.reset();
  points_.reset();
  goal_.reset();
}

}  // namespace frugal_nav
