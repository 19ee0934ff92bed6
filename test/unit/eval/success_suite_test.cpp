// The suite success: what ends a trial, by drivers made for the test, a small run, and its summary from rows
// made by hand.
#include "../../../src/eval/camera_drive.hpp"
#include "../../../src/eval/random_paint.hpp"

#include <functional>

#include <gmock/gmock.h>

#include <frugal_nav/eval/runner.hpp>
#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {
namespace {

const std::string kShare = FRUGAL_NAV_SOURCE_DIR;
constexpr double kRobotWidth_m = 0.25;
constexpr std::uint64_t kSeed = 500006;  // nobody walks there

/// Gives the same velocity, and ends when it is told to.
class SteadyDriver : public CameraDriver {
 public:
  explicit SteadyDriver(const Twist2& velocity) : velocity_(velocity) {}

  Twist2 addTicks(const sim::WheelTicks&) override {
    ++readings;
    return velocity_;
  }
  void addImage(const sim::CameraImage&) override {}
  Pose2 odometry() const override { return {}; }
  bool reached() const override { return readings == reached_after; }
  std::string abortReason() const override { return readings == aborts_after ? "no more" : ""; }
  std::string activity() const override { return "driving on"; }

  int readings = 0;
  int reached_after = -1;
  int aborts_after = -1;

 private:
  Twist2 velocity_;
};

class CameraDriveTest : public testing::Test {
 protected:
  CameraDriveRecord drive(SteadyDriver& driver, double time_limit_s) const {
    sim::SimulatorParams params;
    params.sensors = {true, false, false, false, false};
    sim::Simulator simulator(layout_.scene, loadRobot(kShare + "/urdf/frugal_bot.urdf"), params, kSeed,
                             Pose2{});
    return driveCamera(simulator, layout_, driver, 0.35, time_limit_s);
  }
  const CameraLayout layout_ =
      makeCameraLayout(kSeed, kRobotWidth_m, readTextures(kShare + "/worlds/textures"));
};

TEST_F(CameraDriveTest, EndsWhereTheDriverSaysItIsThere) {
  SteadyDriver driver({0.0, 0.0});
  driver.reached_after = 50;  // readings a second
  const CameraDriveRecord record = drive(driver, 10.0);
  EXPECT_EQ(record.outcome, "reached");
  EXPECT_NEAR(record.time_s, 1.0, 0.05);
  EXPECT_NEAR(record.goal_error_m, layout_.p_stand_off.norm(), 0.01);  // wherever it says it is
  EXPECT_EQ(record.contacts, 0);
}

TEST_F(CameraDriveTest, EndsWhenTheDriverGivesUp) {
  SteadyDriver driver({0.0, 0.0});
  driver.aborts_after = 50;
  const CameraDriveRecord record = drive(driver, 10.0);
  EXPECT_EQ(record.outcome, "aborted");
  EXPECT_EQ(record.reason, "no more");
}

TEST_F(CameraDriveTest, EndsWhenTheTimeIsOver) {
  SteadyDriver driver({0.1, 0.0});
  const CameraDriveRecord record = drive(driver, 3.0);
  EXPECT_EQ(record.outcome, "time_out");
  EXPECT_EQ(record.reason, "driving on");
  EXPECT_NEAR(record.time_s, 3.0, 0.01);
  EXPECT_NEAR(record.length_m, 0.3, 0.05);  // it takes a moment to be that fast
}

TEST_F(CameraDriveTest, EndsWithTheFirstTouch) {
  SteadyDriver driver({0.35, 0.0});
  const CameraDriveRecord record = drive(driver, 60.0);
  EXPECT_EQ(record.outcome, "contact");
  EXPECT_GE(record.contacts, 1);
  EXPECT_EQ(record.walked_into, 0);
  EXPECT_THAT(record.touched, testing::Not(testing::IsEmpty()));
}

TEST(SuccessSuite, BlindDrivingFailsTheSameWayOnAnyNumberOfThreads) {
  RunRequest request;
  request.suite = "success";
  request.context.share_dir = kShare;
  request.context.seed = kSeed;
  request.trials = 1;
  request.options = {{"methods", std::vector<std::string>{"straight"}},
                     {"speeds", std::vector<double>{0.35}}};
  request.threads = 1;
  const Result first = runSuite(request);
  request.threads = 2;
  const Result second = runSuite(request);
  EXPECT_EQ(first.rows, second.rows);
  ASSERT_EQ(first.rows.size(), 1U);
  EXPECT_FALSE(first.rows[0].at("success").get<bool>());
  EXPECT_EQ(first.rows[0].at("cause"), "hit an obstacle");
  EXPECT_EQ(first.summary.at("success_straight_0.35"), 0.0);
}

TEST(SuccessSuite, RefusesWhatItDoesNotKnow) {
  EXPECT_THROW(makeSuite("success")->configure({{"methods", std::vector<std::string>{"radar"}}}),
               ConfigError);
  EXPECT_THROW(makeSuite("success")->configure({{"speeds", std::vector<double>{}}}), ConfigError);
}

Json trial(int index, double speed_mps, const Json& cause, double goal_error_m = 0.1) {
  const bool success = cause.is_null();
  return {{"trial", index},
          {"method", "camera"},
          {"speed_mps", speed_mps},
          {"success", success},
          {"outcome", success ? "reached" : "contact"},
          {"cause", cause},
          {"contacts", success ? 0 : 1},
          {"walked_into", 0},
          {"goal_error_m", goal_error_m}};
}

TEST(SuccessSuite, SharesAreBySpeedAndFailuresByCause) {
  const std::unique_ptr<Suite> suite = makeSuite("success");
  suite->configure({{"speeds", std::vector<double>{0.15, 0.25}}});
  Rows rows;
  for (int i = 0; i < 8; ++i) {
    rows.push_back(trial(i, 0.15, nullptr, 0.2));
    rows.push_back(trial(i, 0.25, i < 6 ? Json("hit an obstacle") : Json()));
  }
  const Json summary = suite->summarise(rows);
  EXPECT_EQ(summary.at("success_0.15"), 1.0);
  EXPECT_EQ(summary.at("success_0.25"), 0.25);
  EXPECT_EQ(summary.at("failed_hit_an_obstacle"), 6);
  EXPECT_EQ(summary.at("contacts"), 6);
  // Wilson's interval of 2 in 8.
  EXPECT_NEAR(summary.at("success_0.25_low").get<double>(), 0.0715, 5e-4);
  EXPECT_NEAR(summary.at("success_0.25_high").get<double>(), 0.5907, 5e-4);
  // Cochran's Q of two conditions is McNemar's: six trials differ, all the same way.
  EXPECT_NEAR(summary.at("friedman_q").get<double>(), 6.0, 1e-9);
  EXPECT_NEAR(summary.at("friedman_p").get<double>(), 0.01431, 1e-4);
  // Errors of those that stopped: eight of 0.2 m, two of 0.1 m.
  EXPECT_NEAR(summary.at("mean_goal_error_m").get<double>(), 0.18, 1e-9);
  EXPECT_TRUE(summary.at("success_straight_0.15").is_null());
}

}  // namespace
}  // namespace frugal_nav::eval
