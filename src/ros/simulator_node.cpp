#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <geometry_msgs/TransformStamped.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/UInt32.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/simulator_messages.hpp>
#include <frugal_nav/ros/simulator_node.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace frugal_nav {
namespace {

// The clock ticks at this period; the wheels' truth comes at twice it.
constexpr Duration kClockPeriod = std::chrono::milliseconds(10);
constexpr Duration kTruthPeriod = std::chrono::milliseconds(20);
// Paused, the clock's value is repeated for those who come late.
constexpr double kPausedPeriod_s = 0.1;

SimulatorNodeParams readParams(const ros::NodeHandle& pnh) {
  SimulatorNodeParams params;
  loadParameters(pnh, params);
  return params;
}

bool isMultiple(Stamp stamp, Duration period) {
  return (stamp - sim::kStartTime) % period == Duration::zero();
}

}  // namespace

sim::SimulatorParams SimulatorNodeParams::withCamera() {
  sim::SimulatorParams params;
  params.sensors.camera = true;
  return params;
}

bool SimulatorNodeParams::waitsFor(const std::string& sensor) const {
  return lockstep &&
         std::find(lockstep_sensors.begin(), lockstep_sensors.end(), sensor) != lockstep_sensors.end();
}

double SimulatorNodeParams::imageRate_hz() const {
  return simulator.sensors.rgbd ? simulator.rgbd.color.rate_hz : simulator.camera.rate_hz;
}

std::string SimulatorNodeParams::check() const {
  if (world.empty()) return "world is not set: name a .world file";
  const sim::SensorSwitches& on = simulator.sensors;
  bool waits = false;
  for (const std::string& sensor : lockstep_sensors) {
    if (sensor == "wheel_ticks") {
      waits = waits || on.wheel_ticks;
    } else if (sensor == "scan") {
      waits = waits || on.scan;
    } else if (sensor == "camera") {
      waits = waits || on.camera || on.rgbd;
    } else {
      return "lockstep_sensors: \"" + sensor + "\" is none of wheel_ticks, scan, camera";
    }
  }
  if (lockstep && !waits) return "lockstep needs one of lockstep_sensors to be switched on";
  const double ticks_an_image = simulator.encoders.rate_hz / imageRate_hz();
  if (waitsFor("camera") && std::abs(ticks_an_image - std::round(ticks_an_image)) > 1e-6)
    return "lock-step on the camera needs its rate to divide that of the encoders: the graph waits for the "
           "odometry of an image's stamp";
  return "";
}

SimulatorNode::SimulatorNode(const ros::NodeHandle& nh, const ros::NodeHandle& pnh)
    : nh_(nh),
      pnh_(pnh),
      params_(readParams(pnh)),
      robot_(loadRobotDescription(nh)),
      pacer_(params_.real_time_factor),
      diagnostics_(nh, pnh),
      start_(ros::WallTime::now()),
      paused_(params_.paused),
      images_(nh) {
  build(params_.world, static_cast<std::uint64_t>(params_.seed));
  if (!ros::Time::isSimTime()) ROS_WARN("use_sim_time is not set: other nodes run on wall time");
  advertise();
  subscribe();
  is_connected_ = !params_.lockstep;
}

void SimulatorNode::advertise() {
  clock_publisher_ = nh_.advertise<rosgraph_msgs::Clock>("/clock", 100, true);
  ticks_publisher_ = nh_.advertise<WheelTicks>("wheel_ticks", 50);
  imu_publisher_ = nh_.advertise<sensor_msgs::Imu>("imu/data_raw", 100);
  scan_publisher_ = nh_.advertise<sensor_msgs::LaserScan>("scan", 10);
  image_publisher_ = images_.advertiseCamera("camera/image_raw", 1);
  if (params_.simulator.sensors.rgbd) depth_publisher_ = images_.advertiseCamera("camera/depth/image_raw", 1);
  truth_publisher_ = nh_.advertise<nav_msgs::Odometry>("ground_truth/odom", 50);
  contact_publisher_ = nh_.advertise<Contact>("ground_truth/contact", 10);
  contact_count_publisher_ = nh_.advertise<std_msgs::UInt32>("ground_truth/contacts", 10, true);
  contact_count_publisher_.publish(std_msgs::UInt32());
  publishClock();
}

void SimulatorNode::subscribe() {
  // A queue of their own, so that commands are heard during a service call too.
  ros::NodeHandle commands(nh_);
  commands.setCallbackQueue(&command_queue_);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  if (params_.lockstep) {
    command_subscriber_ =
        commands.subscribe("cmd_vel_stamped", 100, &SimulatorNode::takeStampedCommand, this, hints);
  } else {
    command_subscriber_ = commands.subscribe<geometry_msgs::Twist>(
        "cmd_vel", 10,
        [this](const geometry_msgs::TwistConstPtr& msg) { takeCommand(*msg, simulator_->stamp()); },
        ros::VoidConstPtr(), hints);
  }
  services_ = {pnh_.advertiseService("pause", &SimulatorNode::pause, this),
               pnh_.advertiseService("resume", &SimulatorNode::resume, this),
               pnh_.advertiseService("step", &SimulatorNode::step, this),
               pnh_.advertiseService("reset_pose", &SimulatorNode::resetPose, this),
               pnh_.advertiseService("load_world", &SimulatorNode::loadWorld, this),
               pnh_.advertiseService("set_seed", &SimulatorNode::setSeed, this)};
}

void SimulatorNode::build(const std::string& world, std::uint64_t seed) {
  const sim::ResourcePath resources = sim::ResourcePath::fromEnvironment();
  const std::optional<std::string> path = resources.find(world, std::filesystem::current_path().string());
  if (!path) {
    throw ConfigError("world \"" + world +
                      "\" does not exist: give a path, or a package:// URI of a package on ROS_PACKAGE_PATH");
  }
  sim::LoadedWorld loaded = sim::loadWorldCached(*path, resources, sim::defaultCacheFolder());
  for (const std::string& warning : loaded.warnings) ROS_WARN("%s: %s", path->c_str(), warning.c_str());
  const Pose2 start{params_.start_x_m, params_.start_y_m, params_.start_yaw_rad};
  simulator_ =
      std::make_unique<sim::Simulator>(std::move(loaded.scene), robot_, params_.simulator, seed, start);
  world_ = world;
  seed_ = seed;
  if (params_.publish_world_tf) publishWorldTf("odom", start);
  if (!params_.map_frame.empty()) publishWorldTf(params_.map_frame, {});
}

void SimulatorNode::publishWorldTf(const std::string& frame, const Pose2& world_from_frame) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "world";
  transform.header.stamp = toRos(simulator_->stamp());
  transform.child_frame_id = frame;
  transform.transform.translation.x = world_from_frame.x_m;
  transform.transform.translation.y = world_from_frame.y_m;
  transform.transform.rotation = toRos(world_from_frame).orientation;
  world_tf_.sendTransform(transform);
}

void SimulatorNode::run() {
  while (ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(
        paused_ || !is_connected_ ? ros::WallDuration(kPausedPeriod_s) : pacer_.untilDue());
    if (paused_ || !graphIsConnected()) {
      publishClock();
    } else if (pacer_.untilDue().isZero()) {
      advance();
    }
  }
}

bool SimulatorNode::graphIsConnected() {
  if (is_connected_) return true;
  const sim::SensorSwitches& on = params_.simulator.sensors;
  const bool ticks_heard = !on.wheel_ticks || ticks_publisher_.getNumSubscribers() > 0;
  const bool scan_heard = !on.scan || scan_publisher_.getNumSubscribers() > 0;
  const bool camera_heard = !params_.waitsFor("camera") || image_publisher_.getNumSubscribers() > 0;
  is_connected_ = ticks_heard && scan_heard && camera_heard && command_subscriber_.getNumPublishers() > 0;
  if (!is_connected_ && (ros::WallTime::now() - start_).toSec() > params_.lockstep_start_wait_s) {
    ROS_WARN("lock-step: no %s after %.0f s; starting the clock without",
             !ticks_heard    ? "subscriber of wheel_ticks"
             : !scan_heard   ? "subscriber of scan"
             : !camera_heard ? "subscriber of camera/image_raw"
                             : "publisher of cmd_vel_stamped",
             params_.lockstep_start_wait_s);
    is_connected_ = true;
  }
  return is_connected_;
}

void SimulatorNode::advance() {
  const Stamp before = simulator_->stamp();
  do {  // whole clock periods: a wake-up for each step would cost more than the step
    stepOnce();
  } while (!isMultiple(simulator_->stamp(), kClockPeriod));
  pacer_.advanced(simulator_->stamp() - before);
}

void SimulatorNode::stepOnce() {
  if (!params_.lockstep) command_queue_.callAvailable();
  switchSensors();
  publish(simulator_->step());
}

void SimulatorNode::switchSensors() {
  sim::SensorSwitches on = params_.simulator.sensors;
  const bool image_wanted = image_publisher_.getNumSubscribers() > 0;
  const bool depth_wanted = on.rgbd && depth_publisher_.getNumSubscribers() > 0;
  // The RGB-D camera gives both images; the plain one rests then.
  on.camera = on.camera && !on.rgbd && image_wanted;
  on.rgbd = on.rgbd && (image_wanted || depth_wanted);
  simulator_->setSensors(on);
}

void SimulatorNode::publish(const sim::SimOutput& output) {
  const bool any = output.ticks || output.imu || output.scan || output.image || output.rgbd;
  if (any || isMultiple(output.stamp, kClockPeriod)) publishClock();
  publishContacts(output);
  if (isMultiple(output.stamp, kTruthPeriod)) truth_publisher_.publish(toRos(simulator_->groundTruth()));
  if (output.imu) imu_publisher_.publish(toRos(*output.imu, params_.simulator.imu));
  if (!params_.waitsFor("camera")) publishImages(output);
  if (output.ticks) {
    publishAndWait("wheel_ticks", output.stamp, [&] { ticks_publisher_.publish(toRos(*output.ticks)); });
  }
  if (output.scan) {
    publishAndWait("scan", output.stamp,
                   [&] { scan_publisher_.publish(toRos(*output.scan, simulator_->scanPeriod())); });
  }
  if (params_.waitsFor("camera") && (output.image || output.rgbd)) {
    publishAndWait("camera", output.stamp, [&] { publishImages(output); });
  }
  if (isMultiple(output.stamp, std::chrono::seconds(1))) report();
}

void SimulatorNode::publishClock() {
  rosgraph_msgs::Clock msg;
  msg.clock = toRos(simulator_->stamp());
  clock_publisher_.publish(msg);
}

void SimulatorNode::publishImages(const sim::SimOutput& output) {
  if (!output.image && !output.rgbd) return;
  const sim::CameraImage& color = output.rgbd ? output.rgbd->color : *output.image;
  const auto info =
      boost::make_shared<sensor_msgs::CameraInfo>(cameraInfo(simulator_->camera(), color.stamp));
  image_publisher_.publish(toRos(color), info);
  if (output.rgbd) depth_publisher_.publish(toRos(output.rgbd->depth), info);
}

void SimulatorNode::publishContacts(const sim::SimOutput& output) {
  if (output.contacts.empty()) return;
  for (const sim::Contact& contact : output.contacts) {
    ROS_WARN("contact: %s with %s at %.2f m/s", contact.robot_link.c_str(), contact.other.c_str(),
             contact.speed_mps);
    contact_publisher_.publish(toRos(contact));
  }
  std_msgs::UInt32 count;
  count.data = static_cast<std::uint32_t>(simulator_->contactCount());
  contact_count_publisher_.publish(count);
}

void SimulatorNode::publishAndWait(const std::string& sensor, Stamp stamp,
                                   const std::function<void()>& send) {
  if (!params_.waitsFor(sensor)) {
    send();
    return;
  }
  command_queue_.callAvailable();  // what came before the message is no answer to it
  awaited_ = stamp;
  is_answered_ = false;
  last_command_.reset();
  send();
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(params_.lockstep_wait_s);
  while (!is_answered_ && ros::ok() && ros::WallTime::now() < deadline) {
    command_queue_.callAvailable(ros::WallDuration(0.05));
  }
  if (!is_answered_) {
    ++missed_waits_;
    diagnostics_.input("cmd_vel_stamped").dropped("no command to " + sensor + " within the wait");
    ROS_WARN_THROTTLE(5.0, "lock-step: no cmd_vel_stamped to %s within %.1f s", sensor.c_str(),
                      params_.lockstep_wait_s);
  }
  if (last_command_) takeCommand(last_command_->twist, toStamp(last_command_->header.stamp));
}

void SimulatorNode::takeStampedCommand(const geometry_msgs::TwistStamped& msg) {
  last_command_ = msg;
  is_answered_ = is_answered_ || toStamp(msg.header.stamp) >= awaited_;
}

void SimulatorNode::takeCommand(const geometry_msgs::Twist& twist, Stamp stamp) {
  InputCounter& counter = diagnostics_.input(params_.lockstep ? "cmd_vel_stamped" : "cmd_vel");
  if (simulator_->setCommand(planar(twist))) {
    counter.received(stamp, simulator_->stamp());
  } else {
    counter.refused("the command is not finite");
    ROS_WARN_THROTTLE(1.0, "a command that is not finite was refused; the wheels stop");
  }
}

void SimulatorNode::report() {
  diagnostics_.set("world", world_);
  diagnostics_.set("contacts", static_cast<double>(simulator_->contactCount()));
  diagnostics_.set("missed lock-step waits", static_cast<double>(missed_waits_));
}

}  // namespace frugal_nav
