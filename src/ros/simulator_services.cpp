#include <algorithm>
#include <cmath>

#include <frugal_nav/ros/simulator_node.hpp>

namespace frugal_nav {

bool SimulatorNode::pause(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  paused_ = true;
  response.success = true;
  return true;
}

bool SimulatorNode::resume(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  paused_ = false;
  pacer_.restart();
  response.success = true;
  return true;
}

bool SimulatorNode::step(StepSimulation::Request& request, StepSimulation::Response& response) {
  if (!paused_) {
    response.message = "the simulation runs: pause it first";
  } else if (!(request.seconds > 0.0 && request.seconds <= 3600.0)) {
    response.message = "seconds must be above 0 and at most 3600";
  } else {
    const std::int64_t steps =
        std::max<std::int64_t>(1, std::llround(request.seconds / toSeconds(sim::kPhysicsStep)));
    for (std::int64_t i = 0; i < steps && ros::ok(); ++i) stepOnce();
    publishClock();
    response.success = true;
  }
  return true;
}

bool SimulatorNode::resetPose(ResetPose::Request& request, ResetPose::Response& response) {
  const Pose2 pose{request.x_m, request.y_m, request.yaw_rad};
  response.success = pose.isFinite();
  if (pose.isFinite()) {
    simulator_->reset(pose);
  } else {
    response.message = "the pose is not finite";
  }
  return true;
}

bool SimulatorNode::loadWorld(LoadWorld::Request& request, LoadWorld::Response& response) {
  try {
    build(request.world, seed_);
    pacer_.restart();
    publishClock();
    response.success = true;
  } catch (const ConfigError& error) {
    response.message = error.what();
    ROS_ERROR("%s", error.what());
  }
  return true;
}

bool SimulatorNode::setSeed(SetSeed::Request& request, SetSeed::Response& response) {
  try {
    build(world_, request.seed);
    pacer_.restart();
    publishClock();
    response.success = true;
  } catch (const ConfigError& error) {  // the file may have changed since
    response.message = error.what();
    ROS_ERROR("%s", error.what());
  }
  return true;
}

}  // namespace frugal_nav
