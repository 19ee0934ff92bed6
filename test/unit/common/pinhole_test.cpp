#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {
namespace {

Pinhole raspberryCamera() {
  Pinhole camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx = camera.fy = 532.5;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.k1 = 0.10;
  camera.k2 = -0.22;
  camera.p1 = 0.0005;
  camera.p2 = -0.0005;
  camera.k3 = 0.05;
  return camera;
}

TEST(Pinhole, ProjectsAsOpenCVDoes) {
  // By hand, (0.3, -0.2): r^2 = 0.13, radial = 1 + 0.13 (0.10 + 0.13 (-0.22 + 0.13 0.05)) = 1.00939185;
  // x = 0.3 radial + 2 p1 x y + p2 (r^2 + 2 x^2) = 0.302602555; y = -0.2 radial + p1 (r^2 + 2 y^2) + 2 p2 x y
  // = -0.20171337.
  const auto pixel = raspberryCamera().project({0.6, -0.4, 2.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 319.5 + 532.5 * 0.302602555, 1e-4);
  EXPECT_NEAR(pixel->y(), 239.5 - 532.5 * 0.20171337, 1e-4);
}

TEST(Pinhole, DoesNotSeeWhatIsBehindIt) {
  EXPECT_FALSE(raspberryCamera().project({0.1, 0.1, -1.0}));
  EXPECT_FALSE(raspberryCamera().project({0.1, 0.1, 0.0}));
}

TEST(Pinhole, LooksThroughThePixelItProjectsTo) {
  const Pinhole camera = raspberryCamera();
  for (const double u : {0.0, 100.0, 319.5, 639.0}) {
    for (const double v : {0.0, 239.5, 479.0}) {
      const auto ray = camera.lookThrough({u, v});
      ASSERT_TRUE(ray) << u << ", " << v;
      const auto pixel = camera.project({ray->point.x(), ray->point.y(), 1.0});
      EXPECT_NEAR(pixel->x(), u, 1e-8);
      EXPECT_NEAR(pixel->y(), v, 1e-8);
    }
  }
}

TEST(Pinhole, KnowsTheDerivativeOfALook) {
  const Pinhole camera = raspberryCamera();
  const Eigen::Vector2d pixel(500.0, 60.0);
  const double step = 1e-3;  // central differences: error about step^2, 1e-12 with these curvatures
  const auto at = [&](double du, double dv) {
    return camera.lookThrough(pixel + Eigen::Vector2d(du, dv))->point;
  };
  const Eigen::Matrix2d jacobian = camera.lookThrough(pixel)->jacobian;
  EXPECT_TRUE(jacobian.col(0).isApprox((at(step, 0) - at(-step, 0)) / (2 * step), 1e-6));
  EXPECT_TRUE(jacobian.col(1).isApprox((at(0, step) - at(0, -step)) / (2 * step), 1e-6));
}

TEST(Pinhole, RefusesToLookPastAFold) {
  Pinhole camera = raspberryCamera();
  camera.k1 = -0.8;  // r (1 - 0.8 r^2) is largest at r = 0.645: 0.43, or 229 px
  camera.k2 = camera.k3 = 0.0;
  EXPECT_TRUE(camera.lookThrough({319.5 + 200.0, 239.5}));
  EXPECT_FALSE(camera.lookThrough({319.5 + 300.0, 239.5}));
}

TEST(Pinhole, ShowsTheSamePlaceOfTheImageWhenItIsResized) {
  const Pinhole camera = raspberryCamera();
  const Pinhole half = camera.scaled(320, 160);
  EXPECT_EQ(half.width_px, 320);
  EXPECT_EQ(half.height_px, 160);
  EXPECT_DOUBLE_EQ(half.cx, 159.5);  // the middle stays the middle
  EXPECT_DOUBLE_EQ(half.cy, 79.5);
  const auto full_pixel = camera.project({0.5, 0.3, 2.0});
  const auto half_pixel = half.project({0.5, 0.3, 2.0});
  EXPECT_NEAR((half_pixel->x() + 0.5) / 320, (full_pixel->x() + 0.5) / 640, 1e-12);
  EXPECT_NEAR((half_pixel->y() + 0.5) / 160, (full_pixel->y() + 0.5) / 480, 1e-12);
}

TEST(Pinhole, NamesWhatMakesItUnusable) {
  EXPECT_EQ(raspberryCamera().fault(), "");
  Pinhole camera = raspberryCamera();
  camera.fx = camera.fy = 0.0;  // what an uncalibrated driver publishes
  EXPECT_NE(camera.fault().find("fx = 0, fy = 0"), std::string::npos) << camera.fault();
  camera = raspberryCamera();
  camera.cx = 700.0;
  EXPECT_NE(camera.fault().find("principal point (700, 239.5)"), std::string::npos) << camera.fault();
  camera = raspberryCamera();
  camera.k2 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(camera.fault().find("distortion"), std::string::npos);
  EXPECT_NE(Pinhole{}.fault().find("image size is 0x0"), std::string::npos);
}

}  // namespace
}  // namespace frugal_nav
