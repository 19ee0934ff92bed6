#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/odometry/visual_cloud.hpp>
#include <frugal_nav/odometry/visual_obstacle.hpp>
#include <frugal_nav/odometry/visual_scale.hpp>

namespace frugal_nav {
namespace {

TEST(VisualScale, IsTheMedianSoThatSlipDoesNotCount) {
  VisualScale scale(5);
  EXPECT_FALSE(scale.estimate());
  for (const double wheel_m : {0.20, 0.21, 0.19, 0.60}) scale.add(wheel_m, 0.1);
  EXPECT_NEAR(scale.estimate()->scale, 2.05, 1e-12);
  scale.add(0.20, 0.1);
  EXPECT_NEAR(scale.estimate()->scale, 2.0, 1e-12);
  EXPECT_LT(scale.estimate()->sigma, 0.1);
  scale.add(0.30, 0.1);  // the first one, 2.0, goes: 1.9 2.0 2.1 3.0 6.0
  EXPECT_NEAR(scale.estimate()->scale, 2.1, 1e-12);
}

TEST(VisualCloud, KeepsOneMeanPointAVoxel) {
  VisualCloud cloud(0.1);
  cloud.add({{1.01, 0.01, 0.01}, {1.03, 0.03, 0.03}, {2.05, 0.05, 0.05}});
  cloud.add({{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, {1e9, 0.0, 0.0}});
  ASSERT_EQ(cloud.points().size(), 2U);
  EXPECT_NEAR(cloud.points()[0].x() + cloud.points()[1].x(), 1.02F + 2.05F, 1e-5F);
  cloud.clear();
  EXPECT_TRUE(cloud.points().empty());
}

/// A robot at the origin that sees points of a box 1.2 m ahead, of a wall behind it, and of the floor.
VisualOdometryOutput boxBeforeAWall() {
  VisualOdometryOutput output;
  output.is_metric = true;
  output.status.scale_sigma = 0.01;
  std::int64_t id = 0;
  const auto add = [&](double x, double y, double z) {
    VisualPoint point;
    point.id = id++;
    point.pixel = {320.0 - 200.0 * y, 240.0};
    point.p_odom = point.p_camera = {x, y, z};
    point.sigma_m = 0.02;
    output.points.push_back(point);
    output.features.emplace_back(static_cast<float>(point.pixel.x()), static_cast<float>(point.pixel.y()));
  };
  for (int i = 0; i < 40; ++i) add(1.2, -0.1 + 0.005 * i, 0.1 + 0.005 * i);
  for (int i = 0; i < 40; ++i) add(3.0, -0.1 + 0.005 * i, 0.5);
  for (int i = 0; i < 40; ++i) add(0.8, -0.1 + 0.005 * i, 0.0);
  for (int i = 0; i < 3; ++i) add(0.4, 0.0, 0.3);  // strays
  for (int i = 0; i < 100; ++i) output.features.emplace_back(320.0F, 240.0F);
  return output;
}

const cv::Rect kWhole(0, 0, 640, 480);

TEST(VisualObstacle, IsTheNearestClusterAboveTheFloor) {
  const VisualObstacleResult result = findNearestObstacle(boxBeforeAWall(), kWhole, {});
  ASSERT_TRUE(result.obstacle) << result.reason;
  // The mean of y is -0.1 + 0.005 * 19.5 = -0.0025.
  EXPECT_NEAR(result.obstacle->distance_m, 1.2, 1e-4);
  EXPECT_NEAR(result.obstacle->bearing_rad, std::atan2(-0.0025, 1.2), 1e-9);
  EXPECT_EQ(result.obstacle->points, 40);
  // 1 % of scale over 1.2 m and 2 cm over 40 points.
  EXPECT_NEAR(result.obstacle->sigma_m, std::hypot(0.012, 0.02 / std::sqrt(40.0)), 1e-3);
}

TEST(VisualObstacle, SkipsARegionWithFewKeypoints) {
  const VisualObstacleResult result = findNearestObstacle(boxBeforeAWall(), cv::Rect(0, 0, 300, 480), {});
  EXPECT_FALSE(result.obstacle);
  EXPECT_EQ(result.keypoints, 0);
  EXPECT_NE(result.reason.find("keypoints"), std::string::npos);
}

TEST(VisualObstacle, NeedsTheScale) {
  VisualOdometryOutput output = boxBeforeAWall();
  output.is_metric = false;
  EXPECT_EQ(findNearestObstacle(output, kWhole, {}).reason, "the scale is unknown");
}

}  // namespace
}  // namespace frugal_nav
