#include "support/ros_test.hpp"

#include <atomic>
#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <geometry_msgs/TwistStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/callback_queue.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/LaserScan.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/SetSeed.h>
#include <frugal_nav/StepSimulation.h>
#include <frugal_nav/ros/conversions.hpp>

// The whole node graph in the simulator, which the test steps: what happens to the base when a part of the
// graph fails. Simulated time, so that the machine's speed does not matter.
namespace frugal_nav {
namespace {

using actionlib::SimpleClientGoalState;
using test::waitUntil;
using testing::StartsWith;

constexpr double kStep_s = 0.02;  // one reading of the encoders
constexpr double kCycle_s = 0.05;

/// Passes a topic on until it is cut; in a thread of its own, since the simulator waits for what follows.
template <class Message>
class Relay {
 public:
  Relay(const std::string& from, const std::string& to) {
    nh_.setCallbackQueue(&queue_);
    publisher_ = nh_.advertise<Message>(to, 50);
    subscriber_ = nh_.subscribe<Message>(
        from, 50, [this](const boost::shared_ptr<const Message>& msg) { pass(*msg); }, ros::VoidConstPtr(),
        ros::TransportHints().tcpNoDelay());
    spinner_.start();
  }

  void cut(bool is_cut) { is_cut_ = is_cut; }
  /// Stamp of the last message that went through.
  ros::Time last() const { return ros::Time().fromNSec(last_ns_); }

 private:
  void pass(const Message& msg) {
    if (is_cut_) return;
    last_ns_ = msg.header.stamp.toNSec();
    publisher_.publish(msg);
  }

  ros::NodeHandle nh_;
  ros::CallbackQueue queue_;
  std::atomic<bool> is_cut_{false};
  std::atomic<std::uint64_t> last_ns_{0};
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

/// Ends a node of this test's graph as a crash would.
bool crash(const std::string& node) {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue uri;
  request[0] = ros::this_node::getName();
  request[1] = ros::names::resolve(node);
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return false;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string>(uri), host, port)) return false;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, response) || response.size() != 3) return false;
  return kill(static_cast<int>(response[2]), SIGKILL) == 0;
}

class GraphStopTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scan_relay = new Relay<sensor_msgs::LaserScan>("scan_raw", "scan");
    odom_relay = new Relay<nav_msgs::Odometry>("odom_raw", "odom");
  }
  static void TearDownTestSuite() {
    delete scan_relay;
    delete odom_relay;
  }

  void SetUp() override {
    scan_relay->cut(false);
    odom_relay->cut(false);
    ASSERT_TRUE(step_service_.waitForExistence(ros::Duration(30.0)));
    ASSERT_TRUE(seed_service_.waitForExistence(ros::Duration(30.0)));
    ASSERT_TRUE(restart());
    client_ = std::make_unique<Client>("move_base", false);
    // Killed nodes are started again by the launch file some seconds later.
    ASSERT_TRUE(stepUntil([this] { return client_->isServerConnected() && isGraphAlive(); }, 60.0));
    const Pose2 goal{4.0, 0.0, 0.0};
    move_base_msgs::MoveBaseGoal msg;
    msg.target_pose.header.frame_id = "odom";
    msg.target_pose.pose = toRos(goal);
    client_->sendGoal(msg);
    ASSERT_TRUE(stepUntil([this] { return speed() > 0.15; }, 10.0)) << "it does not drive";
  }

  /// From time one, the robot at its start.
  bool restart() {
    SetSeed request;
    request.request.seed = 500001;
    if (!seed_service_.call(request) || !request.response.success) return false;
    ros::spinOnce();  // what came before the jump is not of its time
    commands_.clear();
    path_stamp_ = local_stamp_ = ros::Time();
    local_status_ = LocalCommand::STATUS_STOPPED;
    return true;
  }

  /// All nodes answer: planner and avoidance have just processed a scan.
  bool isGraphAlive() const {
    const double newest_s = std::min(path_stamp_.toSec(), local_stamp_.toSec());
    return now_.toSec() - newest_s < 0.15 && local_status_ == LocalCommand::STATUS_IDLE && !commands_.empty();
  }

  bool step() {
    StepSimulation request;
    request.request.seconds = kStep_s;
    const std::size_t before = commands_.size();
    if (!step_service_.call(request) || !request.response.success) return false;
    waitUntil([&] { return commands_.size() > before; }, 0.05);  // none comes while the graph is broken
    return true;
  }

  bool stepUntil(const std::function<bool()>& condition, double wall_limit_s) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(wall_limit_s);
    while (ros::WallTime::now() < end) {
      if (!step()) return false;
      if (condition()) return true;
    }
    return false;
  }

  double speed() const { return commands_.empty() ? 0.0 : commands_.back().v_mps; }
  bool stands() const { return !commands_.empty() && commands_.back().isZero(); }

  /// The base must stand within `limit_s` of simulated time after `since`, and go on standing: at least until
  /// a killed node, started again, gives signs of life.
  void expectStop(ros::Time since, double limit_s, const ros::Time* sign_of_life = nullptr) {
    ASSERT_TRUE(stepUntil([this] { return stands(); }, 30.0)) << "the base never stood";
    const double took_s = (now_ - since).toSec();
    std::printf("stood %.2f s after the last input\n", took_s);
    EXPECT_LE(took_s, limit_s + kCycle_s + kStep_s);
    const ros::Time last_sign = sign_of_life ? *sign_of_life : ros::Time();
    for (int i = 0; i < 25; ++i) {
      ASSERT_TRUE(step());
      if (sign_of_life && *sign_of_life != last_sign) break;
      EXPECT_TRUE(stands());
    }
  }

  static double timeout(const std::string& key) {
    double value = 0.0;
    EXPECT_TRUE(ros::param::get(key, value)) << key;
    return value;
  }

  /// Steps until the goal has ended, and returns how.
  std::string endOfGoal() {
    EXPECT_TRUE(stepUntil([this] { return client_->getState().isDone(); }, 60.0));
    return client_->getState().getText();
  }

  using Client = actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction>;
  inline static Relay<sensor_msgs::LaserScan>* scan_relay = nullptr;
  inline static Relay<nav_msgs::Odometry>* odom_relay = nullptr;

  ros::NodeHandle nh_;
  std::unique_ptr<Client> client_;
  std::vector<Twist2> commands_;
  ros::Time now_;
  ros::Time path_stamp_;
  ros::Time local_stamp_;
  int local_status_ = LocalCommand::STATUS_STOPPED;
  ros::ServiceClient step_service_ = nh_.serviceClient<StepSimulation>("simulator/step");
  ros::ServiceClient seed_service_ = nh_.serviceClient<SetSeed>("simulator/set_seed");
  ros::Subscriber clock_sub_ = nh_.subscribe<rosgraph_msgs::Clock>(
      "/clock", 100, [this](const rosgraph_msgs::ClockConstPtr& msg) { now_ = msg->clock; });
  ros::Subscriber command_sub_ = nh_.subscribe<geometry_msgs::Twist>(
      "cmd_vel", 100, [this](const geometry_msgs::TwistConstPtr& msg) { commands_.push_back(planar(*msg)); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  ros::Subscriber path_sub_ = nh_.subscribe<nav_msgs::Path>(
      "path", 100, [this](const nav_msgs::PathConstPtr& msg) { path_stamp_ = msg->header.stamp; });
  ros::Subscriber local_sub_ =
      nh_.subscribe<LocalCommand>("avoidance/command", 100, [this](const LocalCommandConstPtr& msg) {
        local_stamp_ = msg->header.stamp;
        local_status_ = msg->status;
      });
};

TEST_F(GraphStopTest, StoppedScan) {
  scan_relay->cut(true);
  expectStop(scan_relay->last(), timeout("base_controller/timeouts/scan_s"));
  EXPECT_THAT(endOfGoal(), StartsWith("avoidance stopped"));
}

TEST_F(GraphStopTest, StoppedOdometry) {
  odom_relay->cut(true);
  expectStop(odom_relay->last(), timeout("base_controller/timeouts/odom_s"));
  EXPECT_THAT(endOfGoal(), StartsWith("odometry lost"));
}

TEST_F(GraphStopTest, KilledPlanner) {
  ASSERT_TRUE(crash("planner"));
  expectStop(path_stamp_, timeout("lidar_avoidance/path_timeout_s"), &path_stamp_);
}

TEST_F(GraphStopTest, KilledAvoidance) {
  ASSERT_TRUE(crash("lidar_avoidance"));
  expectStop(local_stamp_, timeout("base_controller/timeouts/avoidance_command_s"), &local_stamp_);
}

TEST_F(GraphStopTest, KilledMission) {
  ASSERT_TRUE(crash("mission"));
  expectStop(now_, timeout("base_controller/timeouts/mission_state_s"));
}

TEST_F(GraphStopTest, CancelledGoal) {
  const std::size_t before = commands_.size();
  client_->cancelGoal();
  // Simulated time stands still: the cancel alone must do it.
  ASSERT_TRUE(waitUntil([&] { return commands_.size() > before; }));
  EXPECT_TRUE(commands_[before].isZero());
  for (int i = 0; i < 25; ++i) {
    ASSERT_TRUE(step());
    EXPECT_TRUE(stands());
  }
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::PREEMPTED);
}

TEST_F(GraphStopTest, TimeJump) {
  ASSERT_TRUE(restart());
  for (int i = 0; i < 25; ++i) {
    ASSERT_TRUE(step());
    EXPECT_TRUE(commands_.empty() || stands());
  }
  EXPECT_FALSE(commands_.empty());
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::ABORTED);
  EXPECT_EQ(client_->getState().getText(), "time jumped back");
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "graph_stop_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
