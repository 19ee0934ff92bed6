#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include <frugal_nav/perception/goal_finder.hpp>

namespace frugal_nav {
namespace {

using State = GoalTracker::State;
using testing::HasSubstr;

/// Finds a bright rectangle.
class BrightBoxDetector : public Detector {
 public:
  std::vector<Detection> detect(const cv::Mat& bgr) override {
    if (!accept(bgr)) return {};
    cv::Mat bright;
    cv::inRange(bgr, cv::Scalar::all(200), cv::Scalar::all(255), bright);
    std::vector<cv::Point> points;
    cv::findNonZero(bright, points);
    if (points.empty()) return {};
    cv::Point low = points[0];
    cv::Point high = points[0];
    for (const cv::Point& p : points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    return {{0, "head", 0.9, cv::Rect2d(cv::Rect(low, high + cv::Point(1, 1)))}};
  }
};

class GoalFinding : public testing::Test {
 protected:
  GoalFinding() : finder_(std::make_unique<BrightBoxDetector>(), flatHead(), GoalTrackerParams{}) {
    view_.camera.width_px = 640;
    view_.camera.height_px = 480;
    view_.camera.fx = view_.camera.fy = 500.0;
    view_.camera.cx = 319.5;
    view_.camera.cy = 239.5;
    view_.base_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    view_.base_from_optical.translation().z() = 0.4;
    show({200, 40, 40, 50});
  }
  static HeadRangeParams flatHead() {
    HeadRangeParams params;
    params.head_height_m = 0.25;
    params.head_depth_m = 0.0;
    return params;
  }
  void show(const cv::Rect& head, const cv::Size& size = {640, 480}) {
    view_.bgr = cv::Mat(size, CV_8UC3, cv::Scalar::all(100));
    view_.bgr(head).setTo(cv::Scalar::all(250));
  }
  GoalFrame frame() {
    view_.stamp += fromSeconds(0.1);
    return finder_.look(view_);
  }

  void findGoal() {
    for (int i = 0; i < 8; ++i) frame();  // longer than GoalTrackerParams::stand_s
  }

  GoalView view_;
  GoalFinder finder_;
};

// Z = 500 * 0.25 / 50 = 2.5 m; the box's centre at 220 is 100 px left of 320: y = 0.5 m.
TEST_F(GoalFinding, PutsTheHeadIntoOdom) {
  view_.odom_from_base = {1.0, 2.0, M_PI / 2};
  findGoal();
  const GoalFrame found = frame();
  EXPECT_EQ(found.fault, "");
  ASSERT_EQ(found.state, State::kSeen);
  EXPECT_NEAR(found.goal->p_odom.x(), 1.0 - 0.5, 1e-9);
  EXPECT_NEAR(found.goal->p_odom.y(), 2.0 + 2.5, 1e-9);
  ASSERT_EQ(found.sightings.size(), 1U);
  EXPECT_EQ(found.sightings[0].status, HeadSighting::Status::kGood);
}

TEST_F(GoalFinding, TakesResizedImages) {
  show({100, 20, 20, 25}, {320, 240});
  findGoal();
  const GoalFrame found = frame();
  ASSERT_EQ(found.state, State::kSeen);
  EXPECT_NEAR(found.goal->p_odom.x(), 2.5, 1e-9);
  EXPECT_NEAR(found.goal->p_odom.y(), 0.5, 1e-9);
}

TEST_F(GoalFinding, SaysWhyAnImageCannotBeUsedAndRecovers) {
  const GoalView sound = view_;
  findGoal();
  view_.bgr = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0));
  EXPECT_EQ(frame().fault, "the image is black");
  EXPECT_EQ(frame().state, State::kUnseen);
  view_.bgr = cv::Mat(480, 640, CV_8UC1, cv::Scalar::all(90));
  EXPECT_THAT(frame().fault, HasSubstr("CV_8UC1"));
  view_.bgr = cv::Mat(480, 480, CV_8UC3, cv::Scalar::all(90));
  EXPECT_THAT(frame().fault, HasSubstr("480x480"));
  view_.bgr = sound.bgr;
  view_.camera.fx = view_.camera.fy = 0.0;
  EXPECT_THAT(frame().fault, HasSubstr("fx = 0"));
  for (int i = 0; i < 20; ++i) frame();
  EXPECT_EQ(frame().state, State::kLost);
  EXPECT_FALSE(frame().goal);
  view_.camera = sound.camera;
  view_.odom_from_base.x_m = std::nan("");
  EXPECT_THAT(frame().fault, HasSubstr("odometry"));
  view_.odom_from_base = Pose2{};
  findGoal();
  EXPECT_EQ(frame().state, State::kSeen);
}

// The head seen at 2.5 m is 0.4 + 2.5 * 175 / 500 = 1.275 m up: from 1 m nearer its top is 1.0 / 1.5 of the
// focal length above the middle, out of the image's upper half of 240 px.
TEST_F(GoalFinding, KeepsAGoalTooNearToBeInView) {
  findGoal();
  view_.odom_from_base.x_m = 1.0;
  view_.bgr.setTo(cv::Scalar::all(100));
  for (int i = 0; i < 50; ++i) EXPECT_EQ(frame().state, State::kUnseen);
  view_.odom_from_base.x_m = 0.0;  // back where it should be seen
  for (int i = 0; i < 20; ++i) frame();
  EXPECT_EQ(frame().state, State::kLost);
}

/// What stands around a bearing at a range, and nothing else within 5 m.
LaserScan bodyAt(Stamp stamp, double bearing_rad, double range_m) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min_rad = -0.8;
  scan.angle_increment_rad = 0.02;
  scan.range_min_m = 0.1;
  scan.range_max_m = 5.0;
  for (int i = 0; i <= 80; ++i) {
    const bool hits = std::abs(scan.angleOf(static_cast<std::size_t>(i)) - bearing_rad) < 0.08;
    scan.ranges_m.push_back(hits ? static_cast<float>(range_m) : std::numeric_limits<float>::infinity());
  }
  return scan;
}

// As above; the person stands 0.25 m farther than the head told, 1.75 m from the robot, half a metre aside.
TEST_F(GoalFinding, PlacesAGoalTooNearToBeInViewByItsFeet) {
  findGoal();
  view_.odom_from_base.x_m = 1.0;
  view_.bgr.setTo(cv::Scalar::all(100));
  const double bearing = std::atan2(0.5, 1.5);
  const double range = std::hypot(1.75, 0.583);
  for (int i = 0; i < 40; ++i) {
    frame();
    finder_.addSurfaces(bodyAt(view_.stamp, bearing, range - FeetParams{}.body_depth_m));
  }
  const GoalFrame found = frame();
  EXPECT_EQ(found.state, State::kUnseen);
  EXPECT_TRUE(found.observed);
  EXPECT_FALSE(frame().observed);  // no surfaces since
  ASSERT_TRUE(found.goal);
  EXPECT_NEAR(found.goal->p_odom.x(), 2.75, 0.05);
  EXPECT_NEAR(found.goal->p_odom.y(), 0.583, 0.05);
}

TEST_F(GoalFinding, DoesNotTakeAWallForTheGoalsFeet) {
  findGoal();
  view_.odom_from_base.x_m = 1.0;
  view_.bgr.setTo(cv::Scalar::all(100));
  for (int i = 0; i < 20; ++i) {
    frame();
    LaserScan wall = bodyAt(view_.stamp, 0.0, 1.7);
    std::fill(wall.ranges_m.begin(), wall.ranges_m.end(), 1.7F);
    finder_.addSurfaces(wall);
  }
  EXPECT_NEAR(frame().goal->p_odom.x(), 2.5, 1e-6);
}

TEST_F(GoalFinding, DoesNotTakeAnotherThingForTheGoalsFeet) {
  findGoal();
  view_.odom_from_base.x_m = 1.0;
  view_.bgr.setTo(cv::Scalar::all(100));
  for (int i = 0; i < 20; ++i) {
    frame();
    finder_.addSurfaces(bodyAt(view_.stamp, std::atan2(0.5, 1.5), 0.8));
  }
  EXPECT_NEAR(frame().goal->p_odom.x(), 2.5, 1e-6);
}

TEST_F(GoalFinding, RefusesBadParametersOfTheFeet) {
  FeetParams feet;
  feet.max_ratio = 0.5;
  EXPECT_THROW(finder_.setParams(flatHead(), GoalTrackerParams{}, feet), ConfigError);
}

// A head of 50 px whose box ends 4 px under the image's upper edge: the detector's box ends before the edge.
TEST_F(GoalFinding, BelievesNoHeadThatTheImageCutsOff) {
  show({200, 4, 40, 50});
  EXPECT_EQ(frame().sightings[0].status, HeadSighting::Status::kCutOff);
  show({200, 12, 40, 50});
  EXPECT_EQ(frame().sightings[0].status, HeadSighting::Status::kGood);
}

}  // namespace
}  // namespace frugal_nav
