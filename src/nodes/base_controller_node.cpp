#include <csignal>

#include <ros/callback_queue.h>
#include <ros/xmlrpc_manager.h>

#include <frugal_nav/ros/base_controller_node.hpp>

// Unlike the other nodes this one must speak once more when it is told to end: zero velocity. roscpp's own
// handlers (signals, `rosnode kill`) close the connections before anyone could.

namespace {

volatile std::sig_atomic_t must_end = 0;

void onSignal(int) { must_end = 1; }

void onShutdownRequest(XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& result) {
  must_end = 1;
  result = ros::xmlrpc::responseInt(1, "", 0);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "base_controller", ros::init_options::NoSigintHandler);
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown", onShutdownRequest);
  const ros::NodeHandle keeps_logging;  // with the last handle ROS shuts down, its log too
  try {
    frugal_nav::BaseControllerNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    while (ros::ok() && must_end == 0) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
    node.stop();
    ros::WallDuration(0.1).sleep();  // roscpp sends from another thread and cannot be asked whether it has
  } catch (const frugal_nav::ConfigError& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
