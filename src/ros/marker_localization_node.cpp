#include <algorithm>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/marker_localization_node.hpp>
#include <frugal_nav/ros/marker_messages.hpp>
#include <frugal_nav/ros/parameters.hpp>

namespace frugal_nav {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using State = LocalizationStatus::State;

constexpr double kReportPeriod_s = 0.5;
constexpr double kPathStep_m = 0.05;
constexpr std::size_t kLongestPath = 4000;  // 200 m

/// What the filter takes, where the parameters do not say otherwise.
MarkerLocalizationParams forClock(MarkerLocalizationParams params) {
  // Simulated time comes in messages of its own, which lag behind the sensors' by some tenths of a second
  // where the simulator runs faster than real time.
  constexpr double kClockLag_s = 1.0;
  if (ros::Time::isSimTime())
    params.filter.future_tolerance_s = std::max(params.filter.future_tolerance_s, kClockLag_s);
  return params;
}

MarkerLocalizationNodeParams load(const ros::NodeHandle& pnh) {
  MarkerLocalizationNodeParams params;
  loadParameters(pnh, params);
  if (params.marker_map.empty()) {
    throw ConfigError(
        pnh.resolveName("marker_map") +
        " is not set: name the file of the markers' places; docs/markers.md tells how to make one");
  }
  return params;
}

}  // namespace

MarkerLocalizationNode::MarkerLocalizationNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : nh_(nh),
      pnh_(pnh),
      params_(load(pnh)),
      localization_(forClock(params_.localization), loadMarkerMap(params_.marker_map)),
      diagnostics_(nh, pnh),
      sensors_(params_.intake.base.base_frame) {
  ImageIntake::Callbacks callbacks;
  callbacks.process = [this](const CameraFrame& frame) { process(frame); };
  callbacks.time_jumped = [this] { forget(); };
  callbacks.silent = [this](const std::string& silence) { silence_ = silence; };
  callbacks.with_odometry = false;  // the filter knows where the robot was, without odometry too
  callbacks.slack = fromSeconds(params_.localization.filter.history_s);  // the filter puts it in its place
  intake_ = std::make_unique<ImageIntake>(nh, params_.intake, diagnostics_, callbacks);
  observations_pub_ = nh.advertise<MarkerObservationArray>("markers", 10);
  fix_pub_ = nh.advertise<PoseMessage>("marker_pose", 10);
  pose_pub_ = nh.advertise<PoseMessage>("pose", 50);
  markers_pub_ = nh.advertise<visualization_msgs::MarkerArray>("marker_localization/markers", 2);
  path_pub_ = nh.advertise<nav_msgs::Path>("marker_localization/path", 1);
  path_.header.frame_id = localization_.map().frame;
  subscribe();
  advertiseServices();
  intake_->stayAwake();
  timer_ = nh.createTimer(ros::Duration(kReportPeriod_s), [this](const ros::TimerEvent&) { reportStatus(); });
  live_ = tuneLive<MarkerLocalizationNodeParams>(pnh, params_,
                                                 [this](const MarkerLocalizationNodeParams& wanted) {
                                                   localization_.setParams(forClock(wanted.localization));
                                                   params_ = wanted;
                                                 });
}

void MarkerLocalizationNode::subscribe() {
  const bool by_command = params_.localization.filter.twist_source == "command";
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  using Node = MarkerLocalizationNode;
  subscribers_ = {nh_.subscribe("odom", 50, &Node::onOdometry, this, hints),
                  nh_.subscribe("imu/data_raw", 100, &Node::onImu, this, hints)};
  if (by_command) subscribers_.push_back(nh_.subscribe("cmd_vel_stamped", 50, &Node::onCommand, this, hints));
  for (const char* topic : {"set_pose", "initialpose"}) {
    subscribers_.push_back(nh_.subscribe<PoseMessage>(
        topic, 1, [this, topic](const geometry_msgs::PoseWithCovarianceStampedConstPtr& msg) {
          setPose(topic, *msg);
        }));
  }
  for (const char* topic : {"odom", "imu/data_raw", "set_pose"}) diagnostics_.input(topic);
  if (by_command) diagnostics_.input("cmd_vel_stamped");
}

void MarkerLocalizationNode::advertiseServices() {
  const bool by_command = params_.localization.filter.twist_source == "command";
  addSwitch("use_markers", FilterInput::kPose, params_.use_markers);
  addSwitch("use_odometry", by_command ? FilterInput::kCommand : FilterInput::kEncoders,
            params_.use_odometry);
  addSwitch("use_imu", FilterInput::kGyro, params_.use_imu);
  const boost::function<bool(SetPose::Request&, SetPose::Response&)> set_pose =
      [this](SetPose::Request& request, SetPose::Response& response) {
        response.message = setPose("set_pose", request.pose);
        response.success = response.message.empty();
        return true;
      };
  services_.push_back(nh_.advertiseService("set_pose", set_pose));
}

void MarkerLocalizationNode::addSwitch(const std::string& name, FilterInput input, bool at_first) {
  localization_.setEnabled(input, at_first);
  const boost::function<bool(std_srvs::SetBool::Request&, std_srvs::SetBool::Response&)> take =
      [this, input, name](std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
        localization_.setEnabled(input, request.data != 0);
        response.success = 1;
        response.message = name + (request.data != 0 ? ": on" : ": off");
        ROS_INFO("%s", response.message.c_str());
        return true;
      };
  services_.push_back(pnh_.advertiseService(name, take));
}

void MarkerLocalizationNode::onOdometry(const nav_msgs::Odometry& msg) {
  const std::optional<Odometry> odometry = fromRos(msg);
  if (!odometry) {
    diagnostics_.input("odom").refused("not finite, or no sound quaternion");
    return;
  }
  if (msg.header.frame_id != params_.intake.base.odom_frame) {
    diagnostics_.input("odom").refused("frame \"" + msg.header.frame_id + "\" instead of \"" +
                                       params_.intake.base.odom_frame + "\"");
    return;
  }
  if (!isStamped("odom", msg.header)) return;
  intake_->checkStamp("odom", odometry->stamp);
  const auto [status, pose] = localization_.addOdometry(*odometry, toStamp(ros::Time::now()));
  note("odom", odometry->stamp, status);
  if (!pose) return;
  publishPose(pose->estimate);
  // Whoever is lost must not drive on by the map: its transform grows stale.
  const bool is_lost = localization_.status(odometry->stamp).state == State::kLost;
  if (params_.publish_tf && !is_lost) broadcast(odometry->stamp, pose->map_from_odom);
}

void MarkerLocalizationNode::onCommand(const geometry_msgs::TwistStamped& msg) {
  if (!isStamped("cmd_vel_stamped", msg.header)) return;
  const Stamp stamp = toStamp(msg.header.stamp);
  intake_->checkStamp("cmd_vel_stamped", stamp);
  const FilterStatus status = localization_.addCommand(stamp, planar(msg.twist), toStamp(ros::Time::now()));
  note("cmd_vel_stamped", stamp, status);
  if (status == FilterStatus::kUsed) publishWithoutOdometry(stamp);
}

void MarkerLocalizationNode::onImu(const sensor_msgs::Imu& msg) {
  const std::optional<Eigen::Isometry3d> base_from_imu = sensors_.baseFrom(msg.header.frame_id);
  if (!base_from_imu) {
    diagnostics_.input("imu/data_raw").dropped("no transform from the frame \"" + msg.header.frame_id + "\"");
    return;
  }
  if (!isStamped("imu/data_raw", msg.header)) return;
  if (msg.angular_velocity_covariance[0] == -1.0) {  // sensor_msgs/Imu: it does not measure this
    diagnostics_.input("imu/data_raw").dropped("without a yaw rate: angular_velocity_covariance[0] is -1");
    return;
  }
  const auto& rate = msg.angular_velocity;
  const double yaw_rate_radps = base_from_imu->linear().row(2).dot(Eigen::Vector3d(rate.x, rate.y, rate.z));
  const Stamp stamp = toStamp(msg.header.stamp);
  note("imu/data_raw", stamp, localization_.addGyro(stamp, yaw_rate_radps, toStamp(ros::Time::now())));
}

void MarkerLocalizationNode::process(const CameraFrame& frame) {
  silence_.clear();
  MarkerImageResult result;
  result.stamp = frame.stamp;
  result.fault = frame.fault;
  if (frame.fault.empty()) {
    const ros::WallTime start = ros::WallTime::now();
    result = localization_.addImage({frame.stamp, frame.camera, frame.base_from_optical}, frame.bgr,
                                    toStamp(ros::Time::now()));
    diagnostics_.set("time of an image [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
    if (!result.fault.empty()) diagnostics_.input("camera/image_raw").refused(result.fault);
  }
  observations_pub_.publish(observationsMessage(frame, result, localization_.map()));
  if (result.fix.isGood()) {
    fix_pub_.publish(
        poseMessage(frame.stamp, localization_.map().frame, result.fix.map_from_base, result.fix.covariance));
  }
  if (result.fault.empty()) publishWithoutOdometry(frame.stamp);
  report(result);
  show(frame, result);
}

std::string MarkerLocalizationNode::setPose(const std::string& input, const PoseMessage& msg) {
  GivenPose given =
      givenPose(msg, localization_.map().frame, params_.set_pose_sigma_m, params_.set_pose_sigma_rad);
  const Stamp now = toStamp(ros::Time::now());
  if (given.fault.empty()) {
    const Stamp stamp = msg.header.stamp.isZero() ? now : toStamp(msg.header.stamp);
    const FilterStatus status = localization_.setPose(stamp, given.fix, now);
    if (status != FilterStatus::kUsed) given.fault = toText(status);
  }
  if (given.fault.empty()) {
    const Pose2& pose = given.fix.map_from_base;
    diagnostics_.input("set_pose").received(now, now);
    ROS_INFO("the robot is put at (%.2f, %.2f), %.2f rad by %s", pose.x_m, pose.y_m, pose.yaw_rad,
             input.c_str());
  } else {
    diagnostics_.input("set_pose").refused(given.fault);
    ROS_WARN("pose on %s refused: %s", input.c_str(), given.fault.c_str());
  }
  return given.fault;
}

bool MarkerLocalizationNode::isStamped(const std::string& input, const std_msgs::Header& header) {
  if (header.stamp.isZero()) diagnostics_.input(input).refused("no stamp");
  return !header.stamp.isZero();
}

void MarkerLocalizationNode::note(const std::string& input, Stamp stamp, FilterStatus status) {
  if (status == FilterStatus::kUsed) {
    diagnostics_.input(input).received(stamp, toStamp(ros::Time::now()));
  } else if (status == FilterStatus::kDisabled || status == FilterStatus::kTooOld) {
    diagnostics_.input(input).dropped(toText(status));
  } else {
    diagnostics_.input(input).refused(toText(status));
    ROS_WARN_THROTTLE(5.0, "%s refused: %s", input.c_str(), toText(status));
  }
}

void MarkerLocalizationNode::publishPose(const PoseEstimate& estimate) {
  pose_pub_.publish(
      poseMessage(estimate.stamp, localization_.map().frame, estimate.map_from_base, estimate.covariance));
  showPath(estimate);
}

/// Of a stamp that was found sound: no pose of an earlier one is given out after it.
void MarkerLocalizationNode::publishWithoutOdometry(Stamp stamp) {
  if (const auto pose = localization_.poseWithoutOdometry(stamp)) publishPose(*pose);
}

void MarkerLocalizationNode::broadcast(Stamp stamp, const Pose2& map_from_odom) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = toRos(stamp);
  transform.header.frame_id = localization_.map().frame;
  transform.child_frame_id = params_.intake.base.odom_frame;
  const geometry_msgs::Pose pose = toRos(map_from_odom);
  transform.transform.translation.x = pose.position.x;
  transform.transform.translation.y = pose.position.y;
  transform.transform.rotation = pose.orientation;
  broadcaster_.sendTransform(transform);
}

void MarkerLocalizationNode::show(const CameraFrame& frame, const MarkerImageResult& result) {
  if (markers_pub_.getNumSubscribers() == 0) return;
  Eigen::Isometry3d map_from_optical = frame.base_from_optical;
  MarkerImageResult shown = result;
  if (const auto estimate = localization_.estimateAt(frame.stamp)) {
    map_from_optical = toIsometry(estimate->map_from_base) * frame.base_from_optical;
  } else {
    shown.fix.sightings.clear();  // nobody knows where they were seen from
  }
  markers_pub_.publish(mapMarkers(localization_.map(), shown, map_from_optical));
}

void MarkerLocalizationNode::showPath(const PoseEstimate& estimate) {
  const geometry_msgs::Pose pose = toRos(estimate.map_from_base);
  if (!path_.poses.empty()) {
    const geometry_msgs::Point& last = path_.poses.back().pose.position;
    if (std::hypot(pose.position.x - last.x, pose.position.y - last.y) < kPathStep_m) return;
  }
  geometry_msgs::PoseStamped place;
  path_.header.stamp = place.header.stamp = toRos(estimate.stamp);
  place.header.frame_id = path_.header.frame_id;
  place.pose = pose;
  if (path_.poses.size() == kLongestPath) path_.poses.erase(path_.poses.begin());
  path_.poses.push_back(place);
  if (path_pub_.getNumSubscribers() > 0) path_pub_.publish(path_);
}

void MarkerLocalizationNode::report(const MarkerImageResult& result) {
  const auto accepted =
      std::count_if(result.fix.sightings.begin(), result.fix.sightings.end(),
                    [&result](const MarkerSighting& sighting) { return result.isAccepted(sighting); });
  diagnostics_.set("markers in the image", static_cast<double>(result.fix.sightings.size()));
  diagnostics_.set("markers accepted", static_cast<double>(accepted));
  diagnostics_.set("last image", result.reason());
  // A lone marker far away may well look alike from two places: that is no fault.
  const bool is_seen = !result.fix.sightings.empty() && result.fix.status != MarkerFix::Status::kAmbiguous;
  const bool is_doubtful = result.fix.isGood() ? !result.isUsed() : is_seen;
  if (is_doubtful) ROS_WARN_THROTTLE(5.0, "markers not used: %s", result.reason().c_str());
}

void MarkerLocalizationNode::reportStatus() {
  const PoseFilterCounts& counts = localization_.counts();
  const auto estimate = localization_.estimate();
  // The newest instant that anything was heard of: simulated time may lag behind it.
  const Stamp now = std::max(toStamp(ros::Time::now()), estimate ? estimate->stamp : Stamp{});
  const LocalizationStatus status = localization_.status(now);
  diagnostics_.set("sigma of the position [m]", status.sigma_m);
  diagnostics_.set("gyro bias [rad/s]", estimate ? estimate->gyro_bias_radps : 0.0);
  diagnostics_.set("replayed late", static_cast<double>(counts.late));
  diagnostics_.set("jumps in time", static_cast<double>(counts.time_jumps));
  diagnostics_.set("restarts from markers", static_cast<double>(counts.restarts));
  diagnostics_.set("fixes gated", static_cast<double>(counts.of(FilterInput::kPose, FilterStatus::kGated)));
  diagnostics_.status(status.state == State::kLost ? DiagnosticStatus::ERROR
                      : status.isSound()           ? DiagnosticStatus::OK
                                                   : DiagnosticStatus::WARN,
                      silence_.empty() ? status.reason : status.reason + "; " + silence_);
  if (counts.restarts > told_restarts_)
    ROS_WARN("the filter started anew from the markers: it had refused too many of their fixes in a row");
  told_restarts_ = counts.restarts;
  if (status.state != told_) ROS_INFO("%s", status.reason.c_str());
  if (status.state == State::kNoFix) ROS_INFO_THROTTLE(10.0, "%s", status.reason.c_str());
  told_ = status.state;
}

void MarkerLocalizationNode::forget() {
  localization_.reset();
  path_.poses.clear();
}

}  // namespace frugal_nav
