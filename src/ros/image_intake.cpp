#include <algorithm>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/image_intake.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.05;
constexpr std::size_t kMostPending = 4;  // images are large, and an old one is of little use
const char* const kImage = "camera/image_raw";
const char* const kInfo = "camera/camera_info";

void checkTransport(const image_transport::ImageTransport& transport, const std::string& name) {
  const std::vector<std::string> known = transport.getLoadableTransports();
  const auto isIt = [&name](const std::string& plugin) { return plugin == "image_transport/" + name; };
  if (std::any_of(known.begin(), known.end(), isIt)) return;
  std::string list;
  for (const std::string& plugin : known) list += " " + plugin.substr(plugin.find('/') + 1);
  throw ConfigError("image_transport \"" + name + "\" is not installed; there is:" + list +
                    " (more in the package image_transport_plugins)");
}

}  // namespace

std_msgs::Header headerOf(const CameraFrame& frame) {
  std_msgs::Header header;
  header.stamp = toRos(frame.stamp);
  header.frame_id = frame.frame;
  return header;
}

ImageIntake::ImageIntake(ros::NodeHandle nh, const ImageIntakeParams& params, NodeDiagnostics& diagnostics,
                         Callbacks callbacks)
    : nh_(nh),
      params_(params),
      diagnostics_(diagnostics),
      callbacks_(std::move(callbacks)),
      time_([this](Stamp) { forget(); }, callbacks_.slack),
      sensors_(params.base.base_frame),
      transport_(nh) {
  checkTransport(transport_, params_.image_transport);
  if (callbacks_.with_odometry)
    odometry_.emplace(nh, params_.base, diagnostics_, time_, [this] { process(); });
  for (const char* topic : {kImage, kInfo}) diagnostics_.input(topic);
  timer_ = nh_.createTimer(ros::Duration(kCheckPeriod_s), [this](const ros::TimerEvent&) { onTimer(); });
}

// Called from the node's own queue, as all else here.
void ImageIntake::watchListeners() {
  const auto isHeard = [](const ros::Publisher& output) { return output.getNumSubscribers() > 0; };
  const bool wanted = always_ || std::any_of(outputs_.begin(), outputs_.end(), isHeard);
  if (wanted == static_cast<bool>(info_sub_)) return;
  if (!wanted) {
    image_sub_.shutdown();
    info_sub_.shutdown();
    pending_.clear();
    return;
  }
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  silence_.heard(ros::Time::now());
  info_sub_ = nh_.subscribe(kInfo, 1, &ImageIntake::onCameraInfo, this, hints);
  image_sub_ = transport_.subscribe(kImage, 1, &ImageIntake::onImage, this,
                                    image_transport::TransportHints(params_.image_transport, hints, nh_));
}

void ImageIntake::onImage(const sensor_msgs::ImageConstPtr& msg) {
  const Stamp stamp = toStamp(msg->header.stamp);
  if (last_image_ == stamp) {
    diagnostics_.input(kImage).dropped("the same stamp twice");
    return;
  }
  time_.checkStamp(kImage, stamp);
  last_image_ = stamp;
  const ros::Time now = ros::Time::now();
  silence_.heard(now);
  diagnostics_.input(kImage).received(stamp, toStamp(now));
  DecodedImage image = decode(msg);
  Pending pending;
  pending.since = now;
  CameraFrame& frame = pending.frame;
  frame.stamp = stamp;
  frame.frame = msg->header.frame_id;
  frame.width_px = static_cast<int>(msg->width);
  frame.height_px = static_cast<int>(msg->height);
  frame.bgr = image.bgr;
  frame.owner = std::move(image.owner);
  frame.fault = image.fault;
  if (frame.fault.empty() && frame.frame.empty()) frame.fault = "the image has no frame";
  if (frame.fault.empty() && msg->header.stamp.isZero()) frame.fault = "the image has no stamp";
  if (!frame.fault.empty()) diagnostics_.input(kImage).refused(frame.fault);
  pending_.push_back(std::move(pending));
  if (pending_.size() > kMostPending && pending_.front().frame.fault.empty()) {
    pending_.front().frame.fault = "more images than can be processed";
    diagnostics_.input(kImage).dropped(pending_.front().frame.fault);
  }
  process();
}

void ImageIntake::onCameraInfo(const sensor_msgs::CameraInfo& msg) {
  diagnostics_.input(kInfo).received(toStamp(msg.header.stamp), toStamp(ros::Time::now()));
  calibration_ = fromRos(msg);
  if (!calibration_->fault.empty()) diagnostics_.input(kInfo).refused(calibration_->fault);
  process();
}

void ImageIntake::onTimer() {
  time_.checkClock();
  watchListeners();  // in a nodelet one may have come while the outputs were still being advertised
  process();
  if (!silence_.isSilent(ros::Time::now(), params_.silent_after_s) || !image_sub_) return;
  const std::string silence = "no image on " + nh_.resolveName(kImage) + ": is the camera's driver running?";
  if (callbacks_.silent) {
    callbacks_.silent(silence);
  } else {
    diagnostics_.status(diagnostic_msgs::DiagnosticStatus::WARN, silence);
  }
  ROS_WARN_THROTTLE(10.0, "%s", silence.c_str());
}

void ImageIntake::forget() {
  pending_.clear();
  if (odometry_) odometry_->clear();
  last_image_.reset();
  callbacks_.time_jumped();
}

double ImageIntake::waited_s() const {
  return pending_.empty() ? 0.0 : (ros::Time::now() - pending_.front().since).toSec();
}

void ImageIntake::process() {
  while (!pending_.empty() && complete(pending_.front())) {
    const CameraFrame frame = std::move(pending_.front().frame);
    pending_.pop_front();
    if (!frame.fault.empty()) ROS_WARN_THROTTLE(5.0, "image not used: %s", frame.fault.c_str());
    callbacks_.process(frame);
  }
}

/// Whether an image can be handed on: everything is there, or will not come any more.
bool ImageIntake::complete(Pending& pending) {
  CameraFrame& frame = pending.frame;
  if (!frame.fault.empty()) return true;
  pending.since = std::min(pending.since, ros::Time::now());  // which may have jumped back
  const Lack lack = fill(frame);
  if (lack.what.empty()) return !callbacks_.ready || callbacks_.ready(frame);
  if (!lack.is_final && waited_s() <= params_.base.odom_wait_s) return false;
  frame.fault = lack.what;
  diagnostics_.input(kImage).dropped(frame.fault);
  return true;
}

ImageIntake::Lack ImageIntake::fill(CameraFrame& frame) {
  if (!calibration_) return {"no camera_info on " + nh_.resolveName(kInfo), false};
  const Calibration calibration = fitTo(*calibration_, frame.bgr.cols, frame.bgr.rows);
  if (!calibration.fault.empty()) return {calibration.fault, true};
  frame.camera = calibration.camera;
  const std::optional<Eigen::Isometry3d> pose = sensors_.baseFrom(frame.frame);
  if (!pose) return {"no transform from " + params_.base.base_frame + " to " + frame.frame, false};
  frame.base_from_optical = *pose;
  if (!odometry_) return {};
  const OdometryIntake::Answer answer = odometry_->at("image", frame.stamp, waited_s());
  if (!answer.odometry) return {answer.isFinal() ? answer.fault : "odometry", answer.isFinal()};
  frame.odometry = *answer.odometry;
  return {};
}

}  // namespace frugal_nav
