#include "support/ros_test.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <gtest/gtest.h>

#include <frugal_nav/ros/live_parameters.hpp>

namespace frugal_nav {
namespace {

struct Params {
  double speed = 1.0;
  int count = 3;
  std::string frame = "odom";

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("speed", speed, Field{"m/s", "how fast", 0.0, 5.0});
    visit("count", count, Field{"", "how many", 0, 10});
    visit("frame", frame, atStart(Field{"", "in which frame"}));
  }
};

using dynamic_reconfigure::Config;

template <class Rows, class Value>
void put(Rows& rows, const std::string& name, const Value& value) {
  rows.emplace_back();
  rows.back().name = name;
  rows.back().value = value;
}

class LiveParametersTest : public testing::Test {
 protected:
  void SetUp() override { spinner_.start(); }

  /// What the node's parameters are after a request, as it tells them.
  Config ask(const Config& wanted) {
    dynamic_reconfigure::Reconfigure service;
    service.request.config = wanted;
    EXPECT_TRUE(ros::service::call("~set_parameters", service));
    return service.response.config;
  }

  ros::NodeHandle pnh_{"~"};
  ros::AsyncSpinner spinner_{1};
  Params now_;
  std::function<void()> on_change_ = [] {};
  std::unique_ptr<LiveParameterServer> server_ =
      tuneLive<Params>(pnh_, Params{}, [this](const Params& params) {
        on_change_();
        now_ = params;
      });
};

TEST_F(LiveParametersTest, TakesANewValue) {
  Config wanted;
  put(wanted.doubles, "speed", 2.5);
  const Config told = ask(wanted);
  EXPECT_EQ(now_.speed, 2.5);
  EXPECT_EQ(now_.count, 3);
  ASSERT_EQ(told.doubles.size(), 1U);
  EXPECT_EQ(told.doubles[0].value, 2.5);
}

TEST_F(LiveParametersTest, AnIntegerForANumberStaysANumber) {
  Config wanted;
  put(wanted.ints, "speed", 2);
  const Config told = ask(wanted);
  EXPECT_EQ(now_.speed, 2.0);
  ASSERT_EQ(told.doubles.size(), 1U);
  EXPECT_EQ(told.doubles[0].value, 2.0);
  EXPECT_EQ(told.ints.size(), 1U) << "count alone";
}

TEST_F(LiveParametersTest, OffersOnlyWhatARunningNodeTakes) {
  Config wanted;
  put(wanted.doubles, "speed", 2.0);
  put(wanted.strs, "frame", std::string("map"));
  const Config told = ask(wanted);
  EXPECT_TRUE(told.strs.empty());
  EXPECT_EQ(now_.speed, 1.0) << "a request that cannot be met changes nothing";
  EXPECT_EQ(now_.frame, "odom");
}

TEST_F(LiveParametersTest, ABadValueChangesNothing) {
  Config wanted;
  put(wanted.doubles, "speed", 9.0);
  EXPECT_EQ(ask(wanted).doubles[0].value, 1.0);
  EXPECT_EQ(now_.speed, 1.0);
}

TEST_F(LiveParametersTest, WhatTheNodeRefusesIsNotKept) {
  on_change_ = [] { throw ConfigError("not now"); };
  Config wanted;
  put(wanted.doubles, "speed", 2.0);
  EXPECT_EQ(ask(wanted).doubles[0].value, 1.0);
  on_change_ = [] {};
  Config other;
  put(other.ints, "count", 4);
  const Config told = ask(other);
  EXPECT_EQ(now_.speed, 1.0) << "the refused value must not come with the next one";
  EXPECT_EQ(told.doubles[0].value, 1.0);
  EXPECT_EQ(now_.count, 4);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_parameters_test");
  const ros::NodeHandle keeps_ros_running;
  return RUN_ALL_TESTS();
}
