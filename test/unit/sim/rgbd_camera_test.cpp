#include "box_scene.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/rgbd_camera.hpp>

namespace frugal_nav::sim {
namespace {

RgbdParams small() {
  RgbdParams params;
  params.color.width_px = 320;
  params.color.height_px = 240;
  return params;
}

cv::Mat depthOf(const BoxScene& world, const RgbdParams& params, const Eigen::Isometry3d& pose) {
  const RayTracer tracer(world.scene);
  const Lighting lighting(LightingParams{}, tracer, 1);
  return RgbdCamera(params, 1).render(tracer, lighting, pose, pose, Stamp{}).depth.depth_m;
}

BoxScene wallAt(double x) {
  BoxScene world;
  world.addBox({1.0F, 40.0F, 40.0F}, at(x + 0.5, 0.0, 0.0), world.addMaterial({0.8F, 0.8F, 0.8F}));
  return world;
}

TEST(RgbdCamera, DepthNoiseGrowsWithTheSquareOfDepth) {
  for (const double z : {1.0, 2.0, 5.0}) {
    const cv::Mat depth = depthOf(wallAt(z), small(), lookAlongX(0, 0, 0));
    double sum = 0.0;
    double squares = 0.0;
    int count = 0;
    for (const float d : cv::Mat_<float>(depth)) {
      ASSERT_FALSE(std::isnan(d));
      sum += static_cast<double>(d) - z;
      squares += (static_cast<double>(d) - z) * (static_cast<double>(d) - z);
      ++count;
    }
    const double sigma = 0.0012 + 0.0019 * z * z;
    // n = 76,800: standard errors sigma / sqrt(n) and sigma / sqrt(2 n); 5 of each.
    EXPECT_NEAR(sum / count, 0.0, 5.0 * sigma / std::sqrt(count)) << z << " m";
    EXPECT_NEAR(std::sqrt(squares / count), sigma, 5.0 * sigma / std::sqrt(2.0 * count)) << z << " m";
  }
}

TEST(RgbdCamera, DepthRunsAlongTheOpticalAxis) {
  RgbdParams params = small();
  params.sigma_a_m = params.sigma_b_per_m = 0.0;
  const cv::Mat depth = depthOf(wallAt(2.0), params, lookAlongX(0, 0, 0));
  EXPECT_NEAR(depth.at<float>(120, 160), 2.0F, 1e-5F);
  EXPECT_NEAR(depth.at<float>(2, 2), 2.0F, 1e-5F) << "a corner's ray is longer, its depth is not";
}

TEST(RgbdCamera, LeavesHolesAtDepthEdges) {
  BoxScene world = wallAt(3.0);
  world.addBox({0.1F, 0.6F, 0.6F}, at(1.55, 0.0, 0.0), 0);  // front face at 1.5 m, wall 3 m
  const cv::Mat depth = depthOf(world, small(), lookAlongX(0, 0, 0));
  const double focal = 160.0 / std::tan(0.5 * RgbdParams{}.color.horizontal_fov_rad);
  const int edge = static_cast<int>(159.5 + focal * 0.3 / 1.5);  // last column of the box
  int holes = 0;
  for (int column = edge - 3; column <= edge + 3; ++column) holes += std::isnan(depth.at<float>(120, column));
  EXPECT_EQ(holes, 2) << "one pixel to each side of the edge";
  EXPECT_NEAR(depth.at<float>(120, 160), 1.5F, 0.05F);
  EXPECT_NEAR(depth.at<float>(120, edge + 10), 3.0F, 0.15F);
}

TEST(RgbdCamera, MeasuresOnlyWithinItsRange) {
  for (const double z : {0.3, 6.5}) {
    const cv::Mat depth = depthOf(wallAt(z), small(), lookAlongX(0, 0, 0));
    for (const float d : cv::Mat_<float>(depth)) ASSERT_TRUE(std::isnan(d)) << z << " m";
  }
  const cv::Mat nothing = depthOf(BoxScene{}, small(), lookAlongX(0, 0, 0));
  for (const float d : cv::Mat_<float>(nothing)) ASSERT_TRUE(std::isnan(d));
}

TEST(RgbdCamera, GrazingSurfaceReturnsNothing) {
  BoxScene world;
  world.addBox({40.0F, 40.0F, 1.0F}, at(0.0, 0.0, -0.5), world.addMaterial({0.8F, 0.8F, 0.8F}));
  RgbdParams params = small();
  params.edge_jump_ratio = 10.0;  // grazing angles alone
  const cv::Mat depth = depthOf(world, params, lookAlongX(0, 0, 0.3));
  const double focal = 160.0 / std::tan(0.5 * params.color.horizontal_fov_rad);
  // Straight ahead the floor's incidence has cosine sin(elevation): 0.15 at 8.6 degrees below the horizon.
  const int limit = static_cast<int>(119.5 + focal * std::tan(std::asin(params.grazing_cos)));
  EXPECT_TRUE(std::isnan(depth.at<float>(limit - 3, 160)));
  EXPECT_FALSE(std::isnan(depth.at<float>(limit + 4, 160)));
}

TEST(RgbdCamera, SameSeedGivesTheSameDepthOnAnyNumberOfThreads) {
  const BoxScene world = wallAt(2.0);
  RgbdParams params = small();
  params.color.threads = 1;
  const cv::Mat one = depthOf(world, params, lookAlongX(0, 0, 0));
  params.color.threads = 2;
  const cv::Mat two = depthOf(world, params, lookAlongX(0, 0, 0));
  EXPECT_EQ(cv::norm(one, two, cv::NORM_INF), 0.0);
}

TEST(RgbdCamera, ProfileHoldsTheDefaults) {
  const std::string path = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/sensors/rgbd_camera.yaml";
  EXPECT_EQ(toYaml(loadParamFile<RgbdParams>(path)), toYaml(RgbdParams{}));
  EXPECT_EQ(readParamFile(path).size(), describe(RgbdParams{}).size()) << "every key stands in the file";
}

}  // namespace
}  // namespace frugal_nav::sim
