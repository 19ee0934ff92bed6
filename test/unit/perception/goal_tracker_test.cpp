#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/perception/goal_tracker.hpp>

namespace frugal_nav {
namespace {

using State = GoalTracker::State;

HeadSighting sightingAt(double x_m, double y_m, double score = 0.9, double sigma_m = 0.1) {
  HeadSighting sighting;
  sighting.status = HeadSighting::Status::kGood;
  sighting.score = score;
  sighting.p_base = {x_m, y_m};
  sighting.range_m = sighting.p_base.norm();
  sighting.above_floor_m = 1.6;
  sighting.from_eye_m = {x_m, y_m, 1.2};
  sighting.noise_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  return sighting;
}

/// Feeds a tracker at 10 Hz.
class GoalTracking : public testing::Test {
 protected:
  State frame(const std::vector<HeadSighting>& sightings, bool could_see = true) {
    time_s_ += 0.1;
    return tracker_.update(stampFromSeconds(time_s_), odom_from_base_, sightings, could_see);
  }
  void findGoalAt(double x_m, double y_m) {
    for (int i = 0; i < 8; ++i) frame({sightingAt(x_m, y_m)});  // longer than stand_s
    ASSERT_EQ(tracker_.state(), State::kSeen);
  }

  GoalTracker tracker_{GoalTrackerParams{}};
  Pose2 odom_from_base_;
  double time_s_ = 100.0;
};

TEST_F(GoalTracking, WantsToSeeItStandForAWhile) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(frame({sightingAt(3, 0)}), State::kNone) << i;
  EXPECT_FALSE(tracker_.goal());
  frame({sightingAt(3, 0)});
  EXPECT_EQ(frame({sightingAt(3, 0)}), State::kSeen);
  ASSERT_TRUE(tracker_.goal());
  EXPECT_EQ(tracker_.goal()->sightings, 8);
  EXPECT_EQ(tracker_.seenBy(), std::optional<std::size_t>(0));
}

TEST_F(GoalTracking, WantsMoreThanOneSighting) {
  EXPECT_EQ(frame({sightingAt(3, 0)}), State::kNone);
  time_s_ += 0.8;
  EXPECT_EQ(frame({sightingAt(3, 0)}), State::kNone);
  EXPECT_EQ(frame({sightingAt(3, 0)}), State::kSeen);
}

// Somebody who walks across at 0.7 m/s, whose bearing is known to 3 cm.
TEST_F(GoalTracking, WhoWalksByIsNotTheGoal) {
  for (int i = 0; i < 40; ++i)
    EXPECT_EQ(frame({sightingAt(3, -1.4 + 0.07 * i, 0.95, 0.03)}), State::kNone) << i;
}

TEST_F(GoalTracking, IsNotFooledByScatteredFalseDetections) {
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frame({sightingAt(2.0 + i % 5, i % 3 - 1.0)}), State::kNone) << i;
}

TEST_F(GoalTracking, ForgetsSightingsThatAreTooFarApart) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(frame({sightingAt(3, 0)}), State::kNone);
    time_s_ += 1.5;
  }
}

TEST_F(GoalTracking, AMissedFrameIsNotALostGoal) {
  findGoalAt(3, 1);
  EXPECT_EQ(frame({}), State::kUnseen);
  ASSERT_TRUE(tracker_.goal());
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 1e-9);
  EXPECT_EQ(frame({sightingAt(3, 1)}), State::kSeen);
}

TEST_F(GoalTracking, IsLostAfterTheTimeOutAndFoundAgain) {
  findGoalAt(3, 1);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frame({}), State::kUnseen) << i;
  EXPECT_EQ(frame({}), State::kLost);
  EXPECT_FALSE(tracker_.goal());
  EXPECT_EQ(frame({}), State::kLost);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(frame({sightingAt(5, -1)}), State::kLost);
  findGoalAt(5, -1);
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 5.0, 1e-9);
}

TEST_F(GoalTracking, KeepsAGoalThatCannotBeSeen) {
  findGoalAt(1.5, 0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(frame({}, false), State::kUnseen);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frame({}, true), State::kUnseen);
  EXPECT_EQ(frame({}, true), State::kLost);
  findGoalAt(1.5, 0);
  time_s_ += 61.0;  // forget_unseeable_s
  EXPECT_EQ(frame({}, false), State::kLost);
}

TEST_F(GoalTracking, StandsStillInOdomWhileTheRobotMoves) {
  findGoalAt(3, 0);
  // At (1, 1), turned left by a quarter: the goal at (3, 0) lies 1 m behind and 2 m to the right.
  odom_from_base_ = {1.0, 1.0, M_PI / 2};
  EXPECT_EQ(frame({sightingAt(-1, -2)}), State::kSeen);
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 1e-9);
  EXPECT_NEAR(tracker_.goal()->p_odom.y(), 0.0, 1e-9);
}

TEST(GoalTracker, TurnsTheUncertaintyIntoOdom) {
  GoalTrackerParams params;
  params.stand_s = params.alike_s = 0.0;
  GoalTracker tracker(params);
  HeadSighting sighting = sightingAt(3, 0);
  sighting.noise_m2.diagonal() << 0.04, 0.0001, 0.0001;  // uncertain along the ray, which is odom's y
  sighting.size_sigma = 0.05;
  for (int i = 1; i <= 3; ++i)
    tracker.update(stampFromSeconds(0.1 * i), {0.0, 0.0, M_PI / 2}, {sighting}, true);
  ASSERT_TRUE(tracker.goal());
  const Eigen::Matrix2d covariance = tracker.goal()->covariance_m2;
  // Three frames average the noise; the head's size, 0.15 m at 3 m, stays. The drift adds 5e-5 m^2 a frame at
  // most.
  EXPECT_NEAR(covariance(1, 1), 0.04 / 3 + 0.0225, 2e-4);
  EXPECT_NEAR(covariance(0, 0), 0.0001 / 3, 2e-4);
}

/// A head at (6, 0), 1.6 m up, of a size a tenth below the assumed one, so that it seems a ninth farther off;
/// seen from x by a camera 0.4 m up.
HeadSighting smallHeadFrom(double x_m) {
  const double apart = 1.0 / 0.9;
  HeadSighting sighting = sightingAt(apart * (6.0 - x_m), 0.0);
  sighting.from_eye_m.z() = apart * 1.2;
  sighting.above_floor_m = 0.4 + sighting.from_eye_m.z();
  const Eigen::Vector3d ray = sighting.from_eye_m.normalized();
  const double along_m = 0.07 * sighting.from_eye_m.norm();
  const double aside_m = 0.004 * sighting.from_eye_m.norm();
  sighting.noise_m2 =
      aside_m * aside_m * Eigen::Matrix3d::Identity() + along_m * along_m * ray * ray.transpose();
  sighting.size_sigma = 0.06;
  return sighting;
}

// The assumed size alone would put it 0.33 m too far at the end.
TEST_F(GoalTracking, TellsTheSizeFromHowTheHeadRisesAsItComesNear) {
  for (int i = 0; i < 100; ++i) {
    odom_from_base_.x_m = 0.03 * i;
    frame({smallHeadFrom(odom_from_base_.x_m)});
  }
  ASSERT_TRUE(tracker_.goal());
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 6.0, 0.1);
  EXPECT_NEAR(tracker_.goal()->above_floor_m, 1.6, 0.05);
}

TEST_F(GoalTracking, KnowsTheSizeOnceToldThePlace) {
  odom_from_base_.x_m = 3.0;
  for (int i = 0; i < 10; ++i) frame({smallHeadFrom(3.0)});
  EXPECT_GT(tracker_.goal()->p_odom.x(), 6.25);
  for (int i = 0; i < 30; ++i) {
    frame({smallHeadFrom(3.0)});
    tracker_.place(stampFromSeconds(time_s_), {6.0, 0.0}, 0.01 * Eigen::Matrix2d::Identity());
  }
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 6.0, 0.06);
  for (int i = 0; i < 30; ++i) frame({smallHeadFrom(3.0)});
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 6.0, 0.06);
}

TEST_F(GoalTracking, KeepsByALowerScoreThanItStarts) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(frame({sightingAt(3, 0, 0.4)}), State::kNone);
  findGoalAt(3, 0);
  EXPECT_EQ(frame({sightingAt(3, 0, 0.3)}), State::kSeen);
  EXPECT_EQ(frame({sightingAt(3, 0, 0.2)}), State::kUnseen);
}

TEST_F(GoalTracking, BelievesNoWeakSightingWhereItCannotBeSeen) {
  findGoalAt(3, 0);
  EXPECT_EQ(frame({sightingAt(3.1, 0.1, 0.4)}, false), State::kUnseen);
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 1e-9);
  EXPECT_EQ(frame({sightingAt(3.1, 0.1, 0.4)}, true), State::kSeen);
}

TEST_F(GoalTracking, IsNoHigherThanItWas) {
  findGoalAt(3, 0);
  HeadSighting shadow = sightingAt(3.2, 0.2, 0.9, 0.05);
  shadow.above_floor_m = 1.2;
  EXPECT_EQ(frame({shadow}), State::kUnseen);
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 1e-9);
}

TEST_F(GoalTracking, KeepsToItsClass) {
  findGoalAt(3, 0);
  HeadSighting other = sightingAt(3, 0);
  other.class_id = 7;
  EXPECT_EQ(frame({other}), State::kUnseen);
}

TEST_F(GoalTracking, KeepsToItsPlaceWhenAnotherPersonIsSeen) {
  findGoalAt(3, 0);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(frame({sightingAt(4, 2, 0.99), sightingAt(3, 0, 0.6)}), State::kSeen);
    EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 0.01);
  }
  EXPECT_EQ(frame({sightingAt(4, 2, 0.99)}), State::kUnseen);
  EXPECT_NEAR(tracker_.goal()->p_odom.x(), 3.0, 0.01);
}

// Where it is seen when the gate lets it in no more it has to stand for stand_s, in which it walks on.
TEST_F(GoalTracking, FollowsAGoalThatWalksSlowly) {
  findGoalAt(3, 0);
  double y_m = 0.0;
  for (int i = 0; i < 50; ++i) {
    y_m += 0.03;  // 0.3 m/s
    EXPECT_NE(frame({sightingAt(3, y_m, 0.9, 0.05)}), State::kLost);
  }
  EXPECT_NEAR(tracker_.goal()->p_odom.y(), y_m, 0.6);
}

TEST_F(GoalTracking, GoesWhereItStandsNowWhenItsPlaceIsEmpty) {
  findGoalAt(3, 0);
  for (int i = 0; i < 8; ++i) EXPECT_NE(frame({sightingAt(3, 0.8, 0.9, 0.03)}), State::kLost);
  EXPECT_NEAR(tracker_.goal()->p_odom.y(), 0.8, 0.02);
}

// Near the goal its head is above the image, and its shadow on the wall is not.
TEST_F(GoalTracking, DoesNotGoElsewhereWhileItsPlaceIsOutOfView) {
  findGoalAt(3, 0);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(frame({sightingAt(3, 0.8, 0.9, 0.03)}, false), State::kUnseen);
  EXPECT_EQ(frame({sightingAt(3, 0.8, 0.9, 0.03)}), State::kUnseen);  // in view again, and missed once
  EXPECT_NEAR(tracker_.goal()->p_odom.y(), 0.0, 0.02);
}

TEST_F(GoalTracking, StaysWhereItIsSeenThoughAnotherStandsNearby) {
  findGoalAt(3, 0);
  for (int i = 0; i < 20; ++i) frame({sightingAt(3, 0.8, 0.9, 0.03), sightingAt(3, 0, 0.6)});
  EXPECT_NEAR(tracker_.goal()->p_odom.y(), 0.0, 0.02);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame({sightingAt(3, 0.8, 0.9, 0.03)}), State::kUnseen);
}

TEST_F(GoalTracking, IgnoresSightingsThatAreNotGood) {
  findGoalAt(3, 0);
  HeadSighting cut_off = sightingAt(3, 0);
  cut_off.status = HeadSighting::Status::kCutOff;
  EXPECT_EQ(frame({cut_off}), State::kUnseen);
  HeadSighting broken = sightingAt(std::nan(""), 0);
  EXPECT_EQ(frame({broken}), State::kUnseen);
  EXPECT_TRUE(tracker_.goal()->p_odom.allFinite());
}

TEST_F(GoalTracking, StartsAnewWhenTimeJumpsBack) {
  findGoalAt(3, 0);
  time_s_ = 50.0;
  EXPECT_EQ(frame({sightingAt(3, 0)}), State::kNone);
  EXPECT_FALSE(tracker_.goal());
}

TEST_F(GoalTracking, TakesAFrameOnce) {
  frame({sightingAt(3, 0)});
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(tracker_.update(stampFromSeconds(time_s_), {}, {sightingAt(3, 0)}, true), State::kNone);
  }
}

// Ten frames of independent noise: the error falls by sqrt(10) = 3.16 on average; the drift lets it be a
// little more.
TEST(GoalTracker, AveragesTheNoiseOverTenFrames) {
  Random random(500003);
  const double sigma = 0.2;
  double single = 0.0;
  double tracked = 0.0;
  const int trials = 500;
  for (int trial = 0; trial < trials; ++trial) {
    GoalTrackerParams params;
    params.confirm_sightings = 2;
    params.stand_s = params.alike_s = 0.0;
    GoalTracker tracker(params);
    HeadSighting sighting;
    for (int i = 1; i <= 10; ++i) {
      sighting = sightingAt(4 + random.normal(sigma), random.normal(sigma), 0.9, sigma);
      tracker.update(stampFromSeconds(0.1 * i), Pose2{}, {sighting}, true);
    }
    const Eigen::Vector2d truth(4, 0);
    single += (sighting.p_base - truth).squaredNorm();
    if (tracker.goal()) tracked += (tracker.goal()->p_odom - truth).squaredNorm();
  }
  EXPECT_LT(std::sqrt(tracked / single), 0.36);  // 1 / 3.16 = 0.316, good to 3 % with 500 trials
  EXPECT_GT(std::sqrt(tracked / single), 0.29);
}

}  // namespace
}  // namespace frugal_nav
