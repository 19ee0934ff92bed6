// From a fitted depth to surfaces, a scan, and things that move.
#include "../../../src/perception/standing_points.hpp"
#include "flat_view.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/perception/column_surface.hpp>
#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/obstacle_motion.hpp>

namespace frugal_nav {
namespace {

TEST(DepthCorrection, WithoutAnchorsChangesNothing) {
  const test::FlatView view;
  const cv::Mat inverse = view.inverseDepth();
  cv::Mat weight;
  EXPECT_EQ(cv::norm(correctDepth(inverse, {}, DepthCorrectionParams{}, &weight), inverse, cv::NORM_INF),
            0.0);
  EXPECT_EQ(cv::norm(weight, cv::NORM_INF), 0.0);
}

// A board fitted 20 % too far, with anchors on its foot: it moves as a whole, the wall behind it does not.
TEST(DepthCorrection, MendsTheSurfaceThatItsAnchorsLieOn) {
  test::FlatView view;
  view.boards = {{1.5, -0.3, 0.3, 0.7}};
  const cv::Mat truth = view.inverseDepth();
  cv::Mat fitted = truth.clone();
  const cv::Mat board = (truth > 0.6) & ~view.floor();
  for (int row = 0; row < truth.rows; ++row) {
    for (int column = 0; column < truth.cols; ++column) {
      if (board.at<uchar>(row, column) != 0)
        fitted.at<float>(row, column) = truth.at<float>(row, column) / 1.2F;
    }
  }
  std::vector<DepthAnchor> anchors;
  for (int column = 70; column < 90; ++column)
    anchors.push_back({cv::Point2f(static_cast<float>(column), 90.0F),
                       static_cast<double>(truth.at<float>(90, column)), 0.02});
  cv::Mat weight;
  const cv::Mat mended = correctDepth(fitted, anchors, DepthCorrectionParams{}, &weight);
  EXPECT_NEAR(mended.at<float>(90, 80) / truth.at<float>(90, 80), 1.0, 0.02);
  EXPECT_NEAR(mended.at<float>(80, 80) / truth.at<float>(80, 80), 1.0, 0.05);
  EXPECT_NEAR(mended.at<float>(60, 10) / truth.at<float>(60, 10), 1.0, 1e-3);
  EXPECT_GT(weight.at<float>(90, 80), 0.9);
  EXPECT_LT(weight.at<float>(60, 10), 0.01);
}

TEST(DepthCorrection, AnAnchorFarOffIsAnotherSurfaces) {
  const test::FlatView view;
  const cv::Mat inverse = view.inverseDepth();
  const std::vector<DepthAnchor> wrong(50, {cv::Point2f(80.0F, 60.0F), 1.5, 0.02, 0.6});
  EXPECT_EQ(cv::norm(correctDepth(inverse, wrong, DepthCorrectionParams{}), inverse, cv::NORM_INF), 0.0);
}

// Every fourth point on a thing lies 8 % too near, which counts as one depth still. By the nearest the thing
// would reach down that far below its foot; their median is exact.
TEST(StandingPoints, ScatterDoesNotBringAThingNearer) {
  test::FlatView view;
  view.boards = {{2.0, -0.3, 0.3, 0.6}};
  const cv::Mat inverse = view.inverseDepth();
  std::vector<DepthAnchor> points;
  for (int row = 66; row < 92; row += 3) {
    for (int column = 66; column < 94; column += 3) {
      const double scatter = points.size() % 4 == 1 ? 1.08 : 1.0;
      const cv::Point2f cell(static_cast<float>(column), static_cast<float>(row));
      points.push_back({cell, scatter * static_cast<double>(inverse.at<float>(row, column)), 0.02});
    }
  }
  double nearest = 0.0;
  cv::minMaxLoc(findStanding(points, view.rays(), 0.5), nullptr, &nearest);
  // At 5 degrees of pitch the point lowest in view is some 2 % nearer than the middle ones.
  EXPECT_LT(nearest * 2.0, 1.04);
  EXPECT_GT(nearest * 2.0, 1.0);
}

class Surfaces : public testing::Test {
 protected:
  std::vector<ColumnSurface> find() {
    const cv::Mat inverse = view_.inverseDepth();
    contacts_ = findFloorContacts(floorEvidence(view_.floor(), FloorContactParams{}), inverse, view_.rays(),
                                  FloorContactParams{});
    refineContacts(view_.image(), view_.rays(), FloorContactParams{}, contacts_);
    return surfacesOf(inverse);
  }
  std::vector<ColumnSurface> surfacesOf(const cv::Mat& inverse) const {
    const cv::Mat sigma(inverse.size(), CV_32FC1, cv::Scalar(0.1));
    return findSurfaces(inverse, sigma, contacts_, view_.rays(), params_);
  }
  float rangeAt(const LaserScan& scan, double bearing_rad) const {
    return scan.ranges_m[static_cast<std::size_t>(
        std::lround((bearing_rad - scan.angle_min_rad) / scan.angle_increment_rad))];
  }
  test::FlatView view_;
  DepthScanParams params_;
  std::vector<FloorContact> contacts_;
};

TEST_F(Surfaces, ScanHasTheDistanceInEachBearing) {
  view_.boards = {{1.8, -0.2, 0.6, 0.6}};
  view_.wall_x_m = 8.0;
  const LaserScan scan = scanOf(find(), view_.rays(), stampFromSeconds(3.0), params_);
  EXPECT_EQ(findFault(scan), std::nullopt);
  EXPECT_NEAR(rangeAt(scan, 0.0), 1.8, 0.05);
  EXPECT_NEAR(rangeAt(scan, 0.2), 1.8 / std::cos(0.2), 0.05);
  EXPECT_TRUE(std::isinf(rangeAt(scan, -0.25)));   // the wall lies beyond the scan's range
  EXPECT_TRUE(std::isnan(scan.ranges_m.front()));  // out of the camera's view
}

TEST_F(Surfaces, ColumnsBetweenNearAndFarTellNothing) {
  view_.boards = {{1.8, -0.2, 0.6, 0.6}};
  find();
  // The edge of the board, blurred: a column half way to the wall behind it.
  int edge = 80;
  while (surfacesOf(view_.inverseDepth())[static_cast<std::size_t>(edge)].depth_m < 2.5F) ++edge;
  FloorContact& mixed = contacts_[static_cast<std::size_t>(edge)];
  mixed.depth_m = 3.0;
  mixed.sigma_m = 0.05;
  const std::vector<ColumnSurface> surfaces = surfacesOf(view_.inverseDepth());
  EXPECT_EQ(surfaces[static_cast<std::size_t>(edge)].state, ColumnSurface::State::kUnknown);
  EXPECT_EQ(surfaces[static_cast<std::size_t>(edge) - 1].state, ColumnSurface::State::kHit);
  EXPECT_EQ(surfaces[static_cast<std::size_t>(edge) + 1].state, ColumnSurface::State::kHit);
}

TEST_F(Surfaces, WhatIsHighPassesOverTheRobot) {
  cv::Mat inverse = view_.inverseDepth();
  find();
  inverse.rowRange(0, 40).setTo(1.0);  // 0.4 + (239.5 - 162) / 532 + 0.087 > 0.5 m up at 1 m
  EXPECT_GT(surfacesOf(inverse)[80].depth_m, 4.0F);
}

TEST_F(Surfaces, AHiddenFloorBoundsTheDistance) {
  view_.boards = {{0.7, -0.2, 0.2, 0.6}};
  find();
  cv::Mat far_off = view_.inverseDepth();
  far_off.setTo(0.3);  // the network sees nothing of it
  const ColumnSurface surface = surfacesOf(far_off)[80];
  EXPECT_EQ(surface.state, ColumnSurface::State::kHit);
  EXPECT_LT(surface.depth_m, 1.2F);
}

// The network blurs the board's edge over the wall: columns beside it hang between the two.
TEST_F(Surfaces, EdgesDoNotFly) {
  view_.boards = {{1.5, -0.3, 0.3, 0.7}};
  find();
  cv::Mat blurred = view_.inverseDepth();
  const auto edge = std::find_if(contacts_.begin() + 80, contacts_.end(),
                                 [](const FloorContact& contact) { return contact.depth_m > 3.0; });
  const auto first = static_cast<int>(edge - contacts_.begin());
  for (int i = 0; i < 3; ++i)
    blurred.col(first + i)(cv::Range(40, 90), cv::Range::all()).setTo(0.6 - 0.12 * i);
  const std::vector<ColumnSurface> surfaces = surfacesOf(blurred);
  EXPECT_NEAR(surfaces[static_cast<std::size_t>(first) - 3].depth_m, 1.5F, 0.1F);
  for (int i = 0; i < 3; ++i) EXPECT_GT(surfaces[static_cast<std::size_t>(first + i)].depth_m, 4.0F) << i;
}

TEST_F(Surfaces, AFaultGivesAScanOfNaN) {
  for (const ViewRays* rays : {&view_.rays(), static_cast<const ViewRays*>(nullptr)}) {
    const LaserScan scan = unknownScan(rays, stampFromSeconds(3.0), params_);
    ASSERT_FALSE(scan.ranges_m.empty());
    for (const float range : scan.ranges_m) EXPECT_TRUE(std::isnan(range));
  }
}

/// Surfaces of some columns at places of base_link.
std::vector<ColumnSurface> thing(int first, int last, const Eigen::Vector2d& from,
                                 const Eigen::Vector2d& to) {
  std::vector<ColumnSurface> surfaces(160);
  for (int column = first; column <= last; ++column) {
    ColumnSurface& surface = surfaces[static_cast<std::size_t>(column)];
    surface.state = ColumnSurface::State::kHit;
    const double share = first == last ? 0.0 : static_cast<double>(column - first) / (last - first);
    surface.p_base = (from + share * (to - from)).cast<float>();
  }
  return surfaces;
}

TEST(JoinedColumns, AreThingsNearestFirst) {
  std::vector<ColumnSurface> surfaces = thing(20, 40, {2.0, 0.8}, {2.0, 0.3});
  for (int column = 60; column < 80; ++column)
    surfaces[static_cast<std::size_t>(column)] =
        thing(60, 79, {1.2, 0.1}, {1.2, -0.1})[static_cast<std::size_t>(column)];
  surfaces[100] = thing(100, 100, {0.5, -0.3}, {0.5, -0.3})[100];  // a speck
  const auto seen = joinColumns(surfaces, std::nullopt, ObstacleMotionParams{});
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_NEAR(seen[0].distance_m, 1.2, 0.01);
  EXPECT_EQ(seen[0].first_column, 60);
  EXPECT_EQ(seen[0].last_column, 79);
  EXPECT_FALSE(seen[0].is_cut_off);
  EXPECT_NEAR(seen[1].p_base.x(), 2.0, 1e-6);
}

TEST(JoinedColumns, ThePersonWhoIsTheGoalIsNone) {
  const auto surfaces = thing(60, 80, {2.0, 0.2}, {2.0, -0.2});
  EXPECT_TRUE(joinColumns(surfaces, Eigen::Vector2d(2.1, 0.0), ObstacleMotionParams{}).empty());
  EXPECT_EQ(joinColumns(surfaces, Eigen::Vector2d(3.0, 0.0), ObstacleMotionParams{}).size(), 1U);
}

class Motion : public testing::Test {
 protected:
  Eigen::Vector2d show(const Eigen::Vector2d& p_odom, const Pose2& robot, bool cut_off = false) {
    SeenObstacle obstacle;
    obstacle.middle_base = robot.inverse() * p_odom;
    obstacle.middle_base += Eigen::Vector2d(random_.normal(0.02), random_.normal(0.02));
    obstacle.is_cut_off = cut_off;
    stamp_ += fromSeconds(0.1);
    return motion_.update(stamp_, robot, {obstacle}).front();
  }
  Random random_{500020};
  ObstacleMotion motion_{ObstacleMotionParams{}};
  Stamp stamp_ = stampFromSeconds(5.0);
};

TEST_F(Motion, AWalkerHasHisVelocity) {
  Eigen::Vector2d velocity;
  for (int i = 0; i < 20; ++i) velocity = show({2.0, -1.0 + 0.06 * i}, {0.02 * i, 0.0, 0.0});
  EXPECT_NEAR(velocity.y(), 0.6, 0.12);
  EXPECT_NEAR(velocity.x(), 0.0, 0.12);
}

TEST_F(Motion, WhatStandsHasNoneWhileTheRobotDrivesAndTurns) {
  for (int i = 0; i < 30; ++i) EXPECT_EQ(show({2.0, 0.3}, {0.025 * i, 0.01 * i, 0.02 * i}).norm(), 0.0) << i;
}

TEST_F(Motion, WhatEntersTheViewHasNone) {
  for (int i = 0; i < 20; ++i) EXPECT_EQ(show({2.0, -1.0 + 0.06 * i}, {}, true).norm(), 0.0);
}

TEST_F(Motion, AnotherThingBeginsAnew) {
  for (int i = 0; i < 20; ++i) show({2.0, -1.0 + 0.06 * i}, {});
  EXPECT_EQ(show({4.0, 2.0}, {}).norm(), 0.0);
}

}  // namespace
}  // namespace frugal_nav
