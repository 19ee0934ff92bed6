#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unit/mission/mission_driver.hpp>

namespace frugal_nav {
namespace {

using ::testing::HasSubstr;
using Vec = Eigen::Vector2d;

/// A robot that obeys, gets paths and no avoidance commands, and sees nobody unless told.
class SearchTest : public ::testing::Test {
 protected:
  explicit SearchTest(const MissionParams& params = cameraParams()) : driver_(params) {
    driver_.feed_command = false;
  }

  void see(const Vec& person) { driver_.mission.setObservedGoal(person, stampFromSeconds(driver_.time_s)); }
  /// Obeys for a while; the angle turned, to the left.
  double obey(double duration_s) {
    double turned_rad = 0.0;
    for (double end_s = driver_.time_s + duration_s; driver_.time_s < end_s - 1e-9;) {
      const double before_rad = driver_.odometry.odom_from_base.yaw_rad;
      output_ = driver_.stepObeying();
      turned_rad += angleBetween(before_rad, driver_.odometry.odom_from_base.yaw_rad);
    }
    return turned_rad;
  }

  MissionDriver driver_;
  MissionOutput output_;
};

TEST_F(SearchTest, TurnsOnTheSpotUntilItSeesSomeone) {
  EXPECT_EQ(obey(3.9), 0.0);                      // looks ahead first
  EXPECT_NEAR(obey(4.0), 0.3 * 3.9, 0.3 * 0.15);  // from 4.0 s on, to within three odometries
  EXPECT_EQ(output_.status.mode, Mode::kAligning);
  EXPECT_EQ(output_.status.phase, MissionPhase::kIdle);
  EXPECT_EQ(output_.command->v_mps, 0.0);
  EXPECT_THAT(output_.status.reason, HasSubstr("look for a person"));
  EXPECT_FALSE(driver_.mission.active());  // no goal that others could plan to

  see({1.0, 3.0});
  EXPECT_EQ(obey(2.0), 0.0);
  EXPECT_EQ(output_.status.mode, Mode::kCamera);
  EXPECT_EQ(output_.status.goal_number, 1U);
  EXPECT_TRUE(driver_.mission.takeEvents().empty());  // the search was no goal that ended
}

TEST_F(SearchTest, GivesUpAfterAFullTurnAndFollowsOneWhoComesLater) {
  const double turned_rad = obey(40.0);
  EXPECT_GE(turned_rad, 2.0 * M_PI);
  EXPECT_LE(turned_rad, 6.5 + 0.3 * 0.05 + 1e-9);  // and one step
  EXPECT_EQ(output_.status.phase, MissionPhase::kAborted);
  EXPECT_EQ(output_.status.mode, Mode::kIdle);
  EXPECT_THAT(output_.status.reason, HasSubstr("none was seen in a full turn"));
  EXPECT_EQ(driver_.mission.takeEvents().size(), 1U);
  EXPECT_EQ(obey(20.0), 0.0);  // once is enough
  see({4.0, 0.0});
  obey(0.1);
  EXPECT_EQ(output_.status.phase, MissionPhase::kDriving);
}

TEST_F(SearchTest, EndsWhenTheTurnIsHeldUp) {
  driver_.run(4.0 + 46.0);  // nothing moves it
  EXPECT_EQ(driver_.mission.status().phase, MissionPhase::kAborted);
  EXPECT_THAT(driver_.mission.status().reason, HasSubstr("held up"));
}

TEST_F(SearchTest, StandsWhileNoImagesComeIn) {
  driver_.feed_path = false;
  EXPECT_EQ(obey(20.0), 0.0);
  EXPECT_EQ(output_.status.mode, Mode::kIdle);
  driver_.feed_path = true;
  EXPECT_GT(obey(6.0), 0.0);
  driver_.feed_path = false;
  obey(1.1);  // the time-out of the path
  EXPECT_EQ(obey(5.0), 0.0);
}

TEST_F(SearchTest, DoesNotLookForOneWhoWasReached) {
  obey(0.1);
  see({1.0, 0.0});
  obey(0.1);
  driver_.odometry.odom_from_base = {0.2, 0.0, 0.0};
  obey(5.0);
  see({1.0, 0.0});
  ASSERT_EQ(driver_.mission.status().phase, MissionPhase::kReached);
  EXPECT_EQ(obey(20.0), 0.0);
}

TEST_F(SearchTest, GivesWayToGoalsAndStopsWhenCancelled) {
  obey(6.0);
  ASSERT_EQ(output_.status.mode, Mode::kAligning);
  driver_.mission.cancel();
  EXPECT_EQ(obey(20.0), 0.0);
  EXPECT_EQ(output_.status.mode, Mode::kIdle);
  driver_.mission.resumeFollowing();
  obey(6.0);
  ASSERT_EQ(output_.status.mode, Mode::kAligning);
  driver_.setGoal({3.0, 0.0, 0.0});
  EXPECT_EQ(obey(1.0), 0.0);
  EXPECT_EQ(output_.status.mode, Mode::kCamera);
}

TEST_F(SearchTest, BeginsAnewWhenTimeJumpsBack) {
  obey(6.0);
  ASSERT_EQ(output_.status.mode, Mode::kAligning);
  driver_.time_s = 10.0;
  EXPECT_EQ(obey(3.0), 0.0);
  EXPECT_GT(obey(3.0), 0.0);
}

MissionParams patientParams() {
  MissionParams params = cameraParams();
  params.search.enabled = false;
  return params;
}

class PatientTest : public SearchTest {
 protected:
  PatientTest() : SearchTest(patientParams()) {}
};

TEST_F(PatientTest, WaitsForAPerson) {
  EXPECT_EQ(obey(30.0), 0.0);
  EXPECT_EQ(output_.status.mode, Mode::kIdle);
  EXPECT_FALSE(output_.command.has_value());
}

TEST(Search, IsForThoseWhoFollowPeople) {
  MissionDriver driver;
  EXPECT_EQ(driver.run(20.0).status.mode, Mode::kIdle);
}

}  // namespace
}  // namespace frugal_nav
