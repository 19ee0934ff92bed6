#include "point_world.hpp"

#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

constexpr double kFocal_px = 530.0;

/// What two views of the room share.
struct TwoViews {
  std::vector<Eigen::Vector3d> points;
  std::vector<Ray2> a;
  std::vector<Ray2> b;
};

TwoViews lookTwice(const Eigen::Isometry3d& world_from_a, const Eigen::Isometry3d& world_from_b,
                   double noise_px, int outliers = 0) {
  PointWorld world(500002);
  const RayMap a = world.see(world_from_a, noise_px);
  const RayMap b = world.see(world_from_b, noise_px);
  TwoViews views;
  for (const auto& [id, ray] : a) {
    const auto other = b.find(id);
    if (other == b.end()) continue;
    views.points.push_back(world.points()[static_cast<std::size_t>(id)]);
    views.a.push_back(ray);
    views.b.push_back(other->second);
    if (outliers-- > 0) views.b.back() += Ray2(0.1, -0.07);
  }
  return views;
}

Eigen::Isometry3d cameraAt(double x, double y, double yaw) { return toIsometry({x, y, yaw}) * cameraMount(); }

double angleTo(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

TEST(VisualGeometry, RefinesAPoseDespiteOutliers) {
  const Eigen::Isometry3d truth = cameraAt(-2.0, 0.5, 0.2);
  const TwoViews views = lookTwice(truth, truth, 0.3, 40);
  const auto fit =
      refinePose(views.points, views.b, cameraAt(-2.05, 0.53, 0.23), kFocal_px, 2.0, std::nullopt);
  ASSERT_TRUE(fit);
  // 0.3 px of noise over some 200 points 4 m away: 0.3 / 530 * 4 / sqrt(200) = 0.2 mm across; ten times that
  // along and beside, where translation and turn look alike.
  EXPECT_LT((fit->world_from_camera.translation() - truth.translation()).norm(), 0.004);
  EXPECT_LT(angleTo(fit->world_from_camera, truth), 0.001);
  EXPECT_EQ(fit->inliers, static_cast<int>(views.points.size()) - 40);
}

TEST(VisualGeometry, CovarianceMatchesTheSpread) {
  const Eigen::Isometry3d truth = cameraAt(-2.0, 0.5, 0.2);
  PointWorld world(500003);
  double sum = 0.0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Ray2> rays;
    for (const auto& [id, ray] : world.see(truth, 1.0)) {
      points.push_back(world.points()[static_cast<std::size_t>(id)]);
      rays.push_back(ray);
    }
    const auto fit = refinePose(points, rays, truth, kFocal_px, 5.0, std::nullopt);
    ASSERT_TRUE(fit);
    const Eigen::Vector3d error = (fit->world_from_camera.inverse() * truth).translation();
    sum += error.dot(fit->covariance.topLeftCorner<3, 3>().inverse() * error) / 3.0;
  }
  // The mean of 60 normalised squares of 3 degrees of freedom has a standard deviation of 0.11; Huber's
  // weights take a tenth of the information that noise of one pixel brings.
  EXPECT_NEAR(sum / kRuns, 1.0, 0.5);
}

TEST(VisualGeometry, FloorKeepsAPoseUpright) {
  const Eigen::Isometry3d truth = cameraAt(-2.0, 0.5, 0.2);
  TwoViews views = lookTwice(truth, truth, 2.0);
  views.points.resize(12);
  views.b.resize(12);
  const PlanarPrior planar{cameraMount().inverse(), 0.005, 0.004};
  const auto free = refinePose(views.points, views.b, truth, kFocal_px, 10.0, std::nullopt);
  const auto held = refinePose(views.points, views.b, truth, kFocal_px, 10.0, planar);
  ASSERT_TRUE(free && held);
  const auto height = [&](const PoseFit& fit) {
    return std::abs((fit.world_from_camera * planar.camera_from_base.translation()).z());
  };
  EXPECT_LT(height(*held), 0.01);
  EXPECT_GT(height(*free), 2.0 * height(*held));
}

TEST(VisualGeometry, FindsAPoseWithoutAGuess) {
  const Eigen::Isometry3d truth = cameraAt(1.0, -1.0, 2.4);
  const TwoViews views = lookTwice(truth, truth, 0.3, 60);
  const auto found = findPose(views.points, views.b, kFocal_px, 2.0);
  ASSERT_TRUE(found);
  EXPECT_LT((found->translation() - truth.translation()).norm(), 0.05);
}

TEST(VisualGeometry, TwoViewsGiveTurnAndCourse) {
  const Eigen::Isometry3d a = cameraAt(-2.0, 0.5, 0.2);
  const Eigen::Isometry3d b = cameraAt(-1.8, 0.55, 0.25);
  const TwoViews views = lookTwice(a, b, 0.3, 30);
  const auto fit = findTwoViewMotion(views.a, views.b, kFocal_px, 1.0);
  ASSERT_TRUE(fit);
  const Eigen::Isometry3d truth = a.inverse() * b;
  // The best of five-ray samples, not refined: 0.3 px / 530 is 0.0006 rad a ray, and the 0.2 m of way make
  // 0.05 rad of parallax at 4 m, so that the course of a sample is good to some 0.1 rad.
  EXPECT_LT(angleTo(fit->a_from_b, truth), 0.01);
  EXPECT_GT(fit->a_from_b.translation().dot(truth.translation().normalized()), std::cos(0.25));
  EXPECT_GE(fit->inliers, static_cast<int>(views.a.size() * 3 / 4));
}

TEST(VisualGeometry, ATurnAloneLeavesNoResidual) {
  Eigen::Isometry3d a = cameraAt(-2.0, 0.5, 0.2);
  Eigen::Isometry3d b = a;
  b.linear() = b.linear() * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const TwoViews turned = lookTwice(a, b, 0.3, 20);
  const auto turn = fitRotation(turned.a, turned.b, kFocal_px, 1.5);
  ASSERT_TRUE(turn);
  EXPECT_LT(turn->median_residual_px, 1.0);
  EXPECT_NEAR(Eigen::AngleAxisd(turn->b_from_a).angle(), 0.2, 0.002);

  const TwoViews moved = lookTwice(a, cameraAt(-1.7, 0.5, 0.2), 0.3);
  EXPECT_GT(fitRotation(moved.a, moved.b, kFocal_px, 1.5)->median_residual_px, 5.0);
}

TEST(VisualGeometry, TriangulatesWithItsParallax) {
  const Eigen::Vector3d p(2.0, 0.3, 0.7);
  std::vector<Sight> sights;
  for (const double x : {-1.0, -0.8, -0.6}) {
    const Eigen::Isometry3d pose = cameraAt(x, 0.1 * x, 0.1);
    const Eigen::Vector3d q = pose.inverse() * p;
    sights.push_back({pose, q.head<2>() / q.z()});
  }
  const auto point = triangulate(sights, kFocal_px);
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_world - p).norm(), 1e-9);
  const Eigen::Vector3d from_first = p - sights.front().world_from_camera.translation();
  const Eigen::Vector3d from_last = p - sights.back().world_from_camera.translation();
  EXPECT_NEAR(point->parallax_rad, std::acos(from_first.normalized().dot(from_last.normalized())), 1e-9);
}

TEST(VisualGeometry, RefusesParallelRaysAndPointsBehind) {
  const Eigen::Isometry3d a = cameraAt(0.0, 0.0, 0.0);
  const Eigen::Isometry3d b = a * Eigen::Translation3d(0.1, 0.0, 0.0);
  EXPECT_FALSE(triangulate({{a, {0.1, 0.0}}, {b, {0.1, 0.0}}}, kFocal_px));
  EXPECT_FALSE(triangulate({{a, {-0.1, 0.0}}, {b, {0.1, 0.0}}}, kFocal_px));  // rays that part
  EXPECT_FALSE(triangulate({{a, {0.0, 0.0}}}, kFocal_px));
}

}  // namespace
}  // namespace frugal_nav
