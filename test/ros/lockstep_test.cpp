#include "support/ros_test.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/TwistStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/SetSeed.h>
#include <frugal_nav/WheelTicks.h>

namespace frugal_nav {
namespace {

using test::Recorder;
using test::waitUntil;

// Wall time in which a simulator that does not wait would be seconds of simulated time on.
constexpr double kQuietWall_s = 0.3;

/// The answering side of a simulator in lock-step.
struct Graph {
  void answer(const ros::Time& stamp, double v_mps = 0.0, double w_radps = 0.0) {
    geometry_msgs::TwistStamped command;
    command.header.stamp = stamp;
    command.twist.linear.x = v_mps;
    command.twist.angular.z = w_radps;
    publisher.publish(command);
  }
  ros::Time lastTicks() const { return ticks.messages.back().header.stamp; }
  ros::Time lastScan() const {
    return scans.messages.empty() ? ros::Time() : scans.messages.back().header.stamp;
  }
  /// Answers ticks and scans until the newest ticks have this stamp and stand unanswered.
  bool answerUntil(const ros::Time& stamp) {
    std::size_t scans_answered = scans.messages.size();
    std::size_t ticks_answered = ticks.messages.size() - 1;
    return waitUntil([&] {
      if (scans.messages.size() > scans_answered) {
        answer(lastScan(), 0.2, 0.3);
        scans_answered = scans.messages.size();
      } else if (ticks.messages.size() > ticks_answered) {
        if (lastTicks() >= stamp) return true;
        answer(lastTicks(), 0.2, 0.3);
        ticks_answered = ticks.messages.size();
      }
      return false;
    });
  }

  ros::NodeHandle nh;
  ros::Publisher publisher = nh.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 100);
  Recorder<WheelTicks> ticks{nh, "wheel_ticks"};
  Recorder<sensor_msgs::LaserScan> scans{nh, "scan"};
  Recorder<nav_msgs::Odometry> truth{nh, "ground_truth/odom"};
};

class LockStep : public testing::Test {
 protected:
  /// Starts the simulation anew and waits for its first ticks, which stand unanswered.
  static void restart(Graph& graph) {
    ASSERT_TRUE(test::waitForSubscriber(graph.publisher));
    ASSERT_TRUE(graph.ticks.waitForPublisher() && graph.scans.waitForPublisher() &&
                graph.truth.waitForPublisher());
    SetSeed seed;
    seed.request.seed = 5;
    ASSERT_TRUE(ros::service::waitForService("simulator/set_seed", 10000));
    ASSERT_TRUE(ros::service::call("simulator/set_seed", seed));
    ASSERT_TRUE(
        waitUntil([&] { return !graph.ticks.messages.empty() && graph.lastTicks() == ros::Time(1.02); }));
    graph.scans.messages.clear();
    graph.truth.messages.clear();
  }

  static std::string diagnosticValue(const Recorder<diagnostic_msgs::DiagnosticArray>& diagnostics,
                                     const std::string& key) {
    std::string found;
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& value : status.values) {
          if (value.key == key) found = value.value;
        }
      }
    }
    return found;
  }
};

TEST_F(LockStep, HoldsTheClockUntilTheGraphIsConnected) {
  ros::NodeHandle nh;
  Recorder<rosgraph_msgs::Clock> clock(nh, "/clock");
  Recorder<WheelTicks> ticks(nh, "wheel_ticks");
  ASSERT_TRUE(clock.waitForCount(5));
  EXPECT_EQ(clock.messages.back().clock, ros::Time(1.0));
  Graph graph;
  ASSERT_TRUE(graph.ticks.waitForCount(1));
  EXPECT_EQ(graph.ticks.messages[0].header.stamp, ros::Time(1.02));
}

TEST_F(LockStep, WaitsForTheCommandToEachSensor) {
  Graph graph;
  restart(graph);
  EXPECT_FALSE(waitUntil([&] { return graph.lastTicks() > ros::Time(1.02); }, kQuietWall_s));
  graph.answer(ros::Time(1.02));
  ASSERT_TRUE(waitUntil([&] { return graph.lastTicks() == ros::Time(1.04); }));
  EXPECT_FALSE(waitUntil([&] { return graph.lastTicks() > ros::Time(1.04); }, kQuietWall_s));
}

TEST_F(LockStep, AnOldCommandIsNoAnswer) {
  Graph graph;
  restart(graph);
  ASSERT_TRUE(graph.answerUntil(ros::Time(1.06)));
  graph.answer(ros::Time(1.04));
  EXPECT_FALSE(waitUntil([&] { return graph.lastTicks() > ros::Time(1.06); }, kQuietWall_s));
}

TEST_F(LockStep, TheScanComesAfterTheCommandToTheTicksOfItsInstant) {
  Graph graph;
  restart(graph);
  ASSERT_TRUE(graph.answerUntil(ros::Time(1.10)));
  EXPECT_FALSE(waitUntil([&] { return graph.lastScan() == ros::Time(1.10); }, kQuietWall_s));
  graph.answer(ros::Time(1.10));
  ASSERT_TRUE(waitUntil([&] { return graph.lastScan() == ros::Time(1.10); }));
  EXPECT_FALSE(waitUntil([&] { return graph.lastTicks() > ros::Time(1.10); }, kQuietWall_s));
  graph.answer(ros::Time(1.10));
  EXPECT_TRUE(waitUntil([&] { return graph.lastTicks() == ros::Time(1.12); }));
}

TEST_F(LockStep, TheSameAnswersGiveTheSameRun) {
  Graph graph;
  std::vector<std::vector<float>> first_scans;
  double first_x_m = 0.0, first_y_m = 0.0;
  for (int run = 0; run < 2; ++run) {
    restart(graph);
    ASSERT_TRUE(graph.answerUntil(ros::Time(3.0)));
    // The truth at 2.98 s was published before the ticks at 3 s, over another connection.
    const auto truthAt = [&](const ros::Time& stamp) -> const nav_msgs::Odometry* {
      for (const nav_msgs::Odometry& truth : graph.truth.messages) {
        if (truth.header.stamp == stamp) return &truth;
      }
      return nullptr;
    };
    ASSERT_TRUE(waitUntil([&] { return truthAt(ros::Time(2.98)) != nullptr; }));
    const auto position = truthAt(ros::Time(2.98))->pose.pose.position;
    ASSERT_GE(graph.scans.messages.size(), 19U);
    if (run == 0) {
      for (std::size_t i = 0; i < 19; ++i) first_scans.push_back(graph.scans.messages[i].ranges);
      first_x_m = position.x;
      first_y_m = position.y;
      EXPECT_GT(first_x_m, 0.2);
      continue;
    }
    EXPECT_EQ(position.x, first_x_m);
    EXPECT_EQ(position.y, first_y_m);
    for (std::size_t i = 0; i < 19; ++i) {
      const std::vector<float>& ranges = graph.scans.messages[i].ranges;
      ASSERT_EQ(ranges.size(), first_scans[i].size());
      for (std::size_t beam = 0; beam < ranges.size(); ++beam) {
        const bool both_unknown = std::isnan(ranges[beam]) && std::isnan(first_scans[i][beam]);
        EXPECT_TRUE(both_unknown || ranges[beam] == first_scans[i][beam]) << "scan " << i << " beam " << beam;
      }
    }
  }
}

TEST_F(LockStep, AMissedWaitGoesOnAndIsCounted) {
  Graph graph;
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(graph.nh, "/diagnostics");
  restart(graph);
  EXPECT_TRUE(waitUntil([&] { return graph.lastTicks() == ros::Time(1.04); }));
  ASSERT_TRUE(graph.answerUntil(ros::Time(3.5)));
  EXPECT_TRUE(waitUntil([&] {
    const std::string missed = diagnosticValue(diagnostics, "missed lock-step waits");
    return !missed.empty() && std::stoi(missed) >= 1;
  }));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "lockstep_test");
  return RUN_ALL_TESTS();
}
