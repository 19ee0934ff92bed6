#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <frugal_nav/sim/contact_world.hpp>
#include <frugal_nav/sim/people.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::sim {
namespace {

// A touch lasts until the two are this far apart: a robot that leans on a wall touches it once.
constexpr double kSeparated_m = 0.005;
// Below this speed toward the other a robot does not drive into it.
constexpr double kApproaching_mps = 0.01;
// A blocked robot stops within this distance of the contact.
constexpr double kContactGap_m = 2e-4;

const double kStep_s = toSeconds(kPhysicsStep);

std::int64_t stepsOf(double rate_hz, std::int64_t unit_steps = 1) {
  const double units = 1.0 / (rate_hz * kStep_s * static_cast<double>(unit_steps));
  return unit_steps * std::max<std::int64_t>(1, std::llround(units));
}

Eigen::Isometry3d lifted(const Pose2& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  result.translation() = Eigen::Vector3d(pose.x_m, pose.y_m, 0.0);
  return result;
}

Scene withPeople(Scene scene, std::vector<PersonBody>& people) {
  people = addPeople(scene);
  return scene;
}

const SimulatorParams& checked(const SimulatorParams& params) {
  validate(params, "simulator");
  return params;
}

void requireFinite(const Pose2& pose) {
  if (!pose.isFinite()) throw ConfigError("simulator: the robot's pose is not finite");
}

/// Throws ConfigError naming the link that a sensor hangs on when the robot lacks it.
void requireLinks(const RobotModel& robot, const SensorSwitches& on) {
  if (on.imu) robot.baseFrom("imu_link");
  if (on.scan) robot.baseFrom("laser");
  if (on.camera || on.rgbd) robot.baseFrom("camera_optical_frame");
}

const Proximity* find(const std::vector<Proximity>& list, int model) {
  const auto found =
      std::find_if(list.begin(), list.end(), [model](const Proximity& p) { return p.model == model; });
  return found == list.end() ? nullptr : &*found;
}

}  // namespace

struct Simulator::Impl {
  Impl(Scene world, RobotModel description, const SimulatorParams& parameters, std::uint64_t random_seed,
       const Pose2& start)
      : params(checked(parameters)),
        seed(random_seed),
        scene(withPeople(std::move(world), people)),
        robot(std::move(description)),
        contact_world(scene, robot),
        body(params.body, robot.drive, seed),
        encoders(params.encoders),
        imu(params.imu,
            params.sensors.imu ? robot.baseFrom("imu_link")
                               : Eigen::Isometry3d(Eigen::Isometry3d::Identity()),
            seed),
        lidar(params.lidar, seed),
        pose(start),
        ticks_steps(stepsOf(params.encoders.rate_hz)),
        scan_steps(stepsOf(params.lidar.rate_hz, ticks_steps)) {
    requireFinite(start);
    requireLinks(robot, params.sensors);
  }

  double worldTime_s() const { return toSeconds(stamp - kStartTime); }
  bool isDue(std::int64_t period_steps) const { return steps % period_steps == 0; }

  void expireCommand();
  void movePeople();
  void moved(int model);
  void moveRobot(std::vector<Contact>& contacts);
  double freeFraction(const Pose2& from, const Pose2& to, const std::vector<Proximity>& before);
  bool isBlocked(const Pose2& from, const Pose2& to, const std::vector<Proximity>& before,
                 const std::vector<Proximity>& after) const;
  Contact describeTouch(const Proximity& touch, const Twist2& twist) const;

  const RayTracer& currentTracer();
  Camera& colorCamera();
  RgbdCamera& depthCamera();
  const Lighting& currentLighting();
  void readSensors(SimOutput& output);
  template <class SomeCamera>
  auto expose(SomeCamera& some_camera, const Camera& lens);

  SimulatorParams params;
  std::uint64_t seed;
  std::vector<PersonBody> people;
  Scene scene;
  RobotModel robot;
  ContactWorld contact_world;
  DriveBody body;
  WheelEncoders encoders;
  Imu imu;
  Lidar lidar;
  // Built when first used: a run without images pays for neither.
  std::unique_ptr<RayTracer> tracer;
  std::unique_ptr<Lighting> lighting;
  std::unique_ptr<Camera> camera;
  std::unique_ptr<RgbdCamera> rgbd;

  Stamp stamp = kStartTime;
  std::int64_t steps = 0;
  Pose2 pose;
  Stamp command_stamp = kStartTime;
  Twist2 twist_at_last_imu;
  std::int64_t ticks_steps;
  std::int64_t scan_steps;
  std::set<int> unseen_moves;   ///< models the tracer has at an old pose
  std::set<int> moved_in_step;  ///< models that moved since the last step
  std::set<int> touching;       ///< models of touches that are not over
  int contact_count = 0;
};

void Simulator::Impl::expireCommand() {
  if (toSeconds(stamp - command_stamp) > params.command_timeout_s) body.command({});
}

void Simulator::Impl::moved(int model) {
  contact_world.updateModel(scene, model);
  unseen_moves.insert(model);
  moved_in_step.insert(model);
}

void Simulator::Impl::movePeople() {
  for (const PersonBody& person : people) {
    if (scene.people[static_cast<std::size_t>(person.person)].waypoints.size() < 2) continue;
    posePerson(person, worldTime_s(), scene);
    moved(person.model);
  }
}

bool Simulator::Impl::isBlocked(const Pose2& from, const Pose2& to, const std::vector<Proximity>& before,
                                const std::vector<Proximity>& after) const {
  for (const Proximity& touch : after) {
    if (touch.distance_m >= 0.0) continue;
    const Proximity* already = find(before, touch.model);
    if (already == nullptr || already->distance_m >= 0.0) return true;
    // Something came to overlap the robot: it may move, but not farther in.
    const Eigen::Vector2d p = already->p_world.head<2>();
    const Eigen::Vector2d way = to * (from.inverse() * p) - p;
    if (way.dot(already->normal_world.head<2>()) < 0.0) return true;
  }
  return false;
}

double Simulator::Impl::freeFraction(const Pose2& from, const Pose2& to,
                                     const std::vector<Proximity>& before) {
  double free = 0.0;
  double blocked = 1.0;
  const double way_m =
      distance(from, to) + std::abs(angleBetween(from.yaw_rad, to.yaw_rad)) * robot.circumradius_m();
  while ((blocked - free) * way_m > kContactGap_m) {
    const double middle = (free + blocked) / 2.0;
    const Pose2 there = interpolate(from, to, middle);
    (isBlocked(from, there, before, contact_world.near(there, kSeparated_m)) ? blocked : free) = middle;
  }
  return free;
}

Contact Simulator::Impl::describeTouch(const Proximity& touch, const Twist2& twist) const {
  Contact contact;
  contact.stamp = stamp;
  contact.robot_link = touch.link;
  contact.other = scene.models[static_cast<std::size_t>(touch.model)].name;
  contact.p_world = touch.p_world;
  contact.depth_m = -touch.distance_m;
  contact.speed_mps = std::abs(twist.v_mps);
  const Eigen::Vector2d arm = touch.p_world.head<2>() - pose.position();
  const Eigen::Vector2d velocity =
      twist.v_mps * Eigen::Vector2d(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad)) +
      twist.w_radps * Eigen::Vector2d(-arm.y(), arm.x());
  const double approach_mps = -velocity.dot(touch.normal_world.head<2>());
  contact.driven_into = moved_in_step.count(touch.model) == 0 || approach_mps > kApproaching_mps;
  return contact;
}

void Simulator::Impl::moveRobot(std::vector<Contact>& contacts) {
  const Pose2 from = pose;
  const Pose2 to = from * body.step(kStep_s);
  const Twist2 twist = body.twist();
  const std::vector<Proximity> after = contact_world.near(to, kSeparated_m);
  pose = to;
  if (after.empty()) {
    touching.clear();
    return;
  }
  const std::vector<Proximity> before = contact_world.near(from, kSeparated_m);
  for (const std::vector<Proximity>* list : {&before, &after}) {
    for (const Proximity& p : *list) {
      if (p.distance_m >= 0.0 || !touching.insert(p.model).second) continue;
      contacts.push_back(describeTouch(p, twist));
      ++contact_count;
    }
  }
  if (isBlocked(from, to, before, after)) {
    const double fraction = freeFraction(from, to, before);
    pose = interpolate(from, to, fraction);
    body.block(fraction);
  }
  const std::vector<Proximity> now = contact_world.near(pose, kSeparated_m);
  for (auto it = touching.begin(); it != touching.end();) {
    it = find(now, *it) == nullptr ? touching.erase(it) : std::next(it);
  }
}

const RayTracer& Simulator::Impl::currentTracer() {
  if (!tracer) {
    tracer = std::make_unique<RayTracer>(scene, params.ray_tracer);
    unseen_moves.clear();
  }
  if (!unseen_moves.empty()) {
    for (const int model : unseen_moves) tracer->updateModel(model);
    tracer->commit();
    unseen_moves.clear();
  }
  return *tracer;
}

const Lighting& Simulator::Impl::currentLighting() {
  if (!lighting) lighting = std::make_unique<Lighting>(params.lighting, currentTracer(), seed);
  return *lighting;
}

Camera& Simulator::Impl::colorCamera() {
  if (!camera) camera = std::make_unique<Camera>(params.camera, seed);
  return *camera;
}

RgbdCamera& Simulator::Impl::depthCamera() {
  if (!rgbd) rgbd = std::make_unique<RgbdCamera>(params.rgbd, seed);
  return *rgbd;
}

template <class SomeCamera>
auto Simulator::Impl::expose(SomeCamera& some_camera, const Camera& lens) {
  // The stamp is the middle of the exposure; over so short a time the robot holds its twist.
  const double half_s = lens.exposureTime_s() / 2.0;
  const Eigen::Isometry3d& base_from_optical = robot.baseFrom("camera_optical_frame");
  const RayTracer& scene_tracer = currentTracer();
  return some_camera.render(scene_tracer, currentLighting(),
                            lifted(pose * arcMotion(body.twist(), -half_s)) * base_from_optical,
                            lifted(pose * arcMotion(body.twist(), half_s)) * base_from_optical, stamp);
}

void Simulator::Impl::readSensors(SimOutput& output) {
  const SensorSwitches& on = params.sensors;
  if (on.wheel_ticks && isDue(ticks_steps)) {
    output.ticks = encoders.sample(stamp, body.leftAngle_rad(), body.rightAngle_rad());
  }
  if (const std::int64_t imu_steps = stepsOf(params.imu.rate_hz); isDue(imu_steps)) {
    const double period_s = static_cast<double>(imu_steps) * kStep_s;
    const Twist2 twist = body.twist();
    const Twist2 rate{(twist.v_mps - twist_at_last_imu.v_mps) / period_s,
                      (twist.w_radps - twist_at_last_imu.w_radps) / period_s};
    twist_at_last_imu = twist;
    if (on.imu) output.imu = imu.sample(stamp, twist, rate);
  }
  if (on.scan && isDue(scan_steps)) {
    output.scan = lidar.scan(currentTracer(), lifted(pose) * robot.baseFrom("laser"), stamp);
  }
  if (on.camera && isDue(stepsOf(params.camera.rate_hz))) output.image = expose(colorCamera(), colorCamera());
  if (on.rgbd && isDue(stepsOf(params.rgbd.color.rate_hz))) {
    output.rgbd = expose(depthCamera(), depthCamera().camera());
  }
}

Simulator::Simulator(Scene scene, RobotModel robot, const SimulatorParams& params, std::uint64_t seed,
                     const Pose2& world_from_start)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(robot), params, seed, world_from_start)) {}

Simulator::~Simulator() = default;

bool Simulator::setCommand(const Twist2& command) {
  const bool sound = command.isFinite();
  impl_->body.command(sound ? command : Twist2{});
  impl_->command_stamp = impl_->stamp;
  return sound;
}

SimOutput Simulator::step() {
  SimOutput output;
  impl_->stamp += kPhysicsStep;
  ++impl_->steps;
  impl_->expireCommand();
  impl_->movePeople();
  impl_->moveRobot(output.contacts);
  impl_->readSensors(output);
  impl_->moved_in_step.clear();
  output.stamp = impl_->stamp;
  return output;
}

Stamp Simulator::stamp() const { return impl_->stamp; }

GroundTruth Simulator::groundTruth() const { return {impl_->stamp, impl_->pose, impl_->body.twist()}; }

int Simulator::contactCount() const { return impl_->contact_count; }

void Simulator::reset(const Pose2& world_from_base) {
  requireFinite(world_from_base);
  impl_->pose = world_from_base;
  impl_->body.command({});
  impl_->body.block(1.0);
  impl_->twist_at_last_imu = {};
  impl_->touching.clear();
}

void Simulator::setSensors(const SensorSwitches& sensors) { impl_->params.sensors = sensors; }

void Simulator::moveModel(int model, const Eigen::Isometry3d& world_from_model) {
  if (model < 0 || model >= static_cast<int>(impl_->scene.models.size())) {
    throw ConfigError("simulator: the world \"" + impl_->scene.name + "\" has no model number " +
                      std::to_string(model));
  }
  impl_->scene.models[static_cast<std::size_t>(model)].world_from_model = world_from_model;
  impl_->moved(model);
}

void Simulator::startPerson(int person) {
  if (person < 0 || person >= static_cast<int>(impl_->scene.people.size())) {
    throw ConfigError("simulator: the world \"" + impl_->scene.name + "\" has no person number " +
                      std::to_string(person));
  }
  impl_->scene.people[static_cast<std::size_t>(person)].start_delay_s = impl_->worldTime_s();
}

Duration Simulator::scanPeriod() const { return impl_->scan_steps * kPhysicsStep; }
const Scene& Simulator::scene() const { return impl_->scene; }
const RobotModel& Simulator::robot() const { return impl_->robot; }
const SimulatorParams& Simulator::params() const { return impl_->params; }

const Camera& Simulator::camera() const {
  const SensorSwitches& on = impl_->params.sensors;
  return on.rgbd && !on.camera ? impl_->depthCamera().camera() : impl_->colorCamera();
}

const RayTracer& Simulator::tracer() const { return impl_->currentTracer(); }

}  // namespace frugal_nav::sim
