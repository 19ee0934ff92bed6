#include "box_scene.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/camera.hpp>

namespace frugal_nav::sim {
namespace {

/// A camera whose exposure is fixed and whose images are clean.
CameraParams plain(double exposure_s = 0.005) {
  CameraParams params;
  params.shortest_exposure_s = params.longest_exposure_s = exposure_s;
  params.gain_limit = 1.0;
  params.shot_noise = false;
  params.read_noise_e = 0.0;
  return params;
}

LightingParams lit(double illuminance_lx) {
  LightingParams params;
  params.illuminance_lx = illuminance_lx;
  return params;
}

/// A wide floor at z = 0 under a vertical sun.
BoxScene floorOf(const Eigen::Vector3f& srgb) {
  BoxScene world;
  world.addBox({20.0F, 20.0F, 1.0F}, at(0.0, 0.0, -0.5), world.addMaterial(srgb));
  world.addSun({0.0, 0.0, -1.0});
  return world;
}

double linearOf(double byte) {
  const double srgb = byte / 255.0;
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double meanOf(const cv::Mat& bgr, const cv::Rect& region) {
  const cv::Scalar mean = cv::mean(bgr(region));
  return (mean[0] + mean[1] + mean[2]) / 3.0;
}

double deviationOf(const cv::Mat& bgr, const cv::Rect& region) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(bgr(region), mean, deviation);
  return deviation[1];
}

constexpr int kMiddle = 40;
const cv::Rect kCentre(320 - kMiddle, 240 - kMiddle, 2 * kMiddle, 2 * kMiddle);

CameraImage renderStill(Camera& camera, const RayTracer& tracer, const Lighting& lighting,
                        const Eigen::Isometry3d& pose, int frames = 1) {
  CameraImage image;
  for (int i = 0; i < frames; ++i) image = camera.render(tracer, lighting, pose, pose, Stamp{});
  return image;
}

/// Centroid of what is bright near a pixel.
cv::Point2d centroidNear(const cv::Mat& bgr, const cv::Point2d& guess) {
  constexpr int kReach = 14;
  double weight = 0.0;
  cv::Point2d sum(0.0, 0.0);
  for (int row = cvRound(guess.y) - kReach; row <= cvRound(guess.y) + kReach; ++row) {
    for (int column = cvRound(guess.x) - kReach; column <= cvRound(guess.x) + kReach; ++column) {
      if (row < 0 || column < 0 || row >= bgr.rows || column >= bgr.cols) continue;
      const double w = linearOf(bgr.at<cv::Vec3b>(row, column)[1]);
      weight += w;
      sum += w * cv::Point2d(column, row);
    }
  }
  return sum / weight;
}

TEST(Camera, ShowsPointsWhereItsPublishedModelProjectsThem) {
  BoxScene world;
  const int black = world.addMaterial({0, 0, 0});
  const int white = world.addMaterial({1, 1, 1});
  world.scene.background.setZero();
  world.addSun({1.0, 0.0, -0.5});
  world.addBox({0.2F, 8.0F, 8.0F}, at(2.3, 0.0, 0.0), black);  // front face at x = 2.2
  std::vector<cv::Point3d> points;                             // in the optical frame
  for (int i = -5; i <= 5; ++i) {
    for (int k = -3; k <= 3; ++k) {
      const double depth = 2.0 + 0.02 * (i + k);
      Eigen::Isometry3d pose = at(depth + 0.0005, -0.22 * i, -0.26 * k);
      // Rolled, so that its edges cross the pixels at all phases and the centroid averages over them.
      pose.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
      world.addBox({0.001F, 0.04F, 0.04F}, pose, white);
      points.emplace_back(0.22 * i, 0.26 * k, depth);
    }
  }
  CameraParams params = plain();
  params.k1 = 0.15;
  params.k2 = -0.30;
  params.p1 = 0.002;
  params.p2 = -0.003;
  const RayTracer tracer(world.scene);
  const Lighting lighting(lit(500.0), tracer, 1);
  Camera camera(params, 1);
  const cv::Mat image = renderStill(camera, tracer, lighting, lookAlongX(0, 0, 0)).bgr;

  std::vector<cv::Point2d> projected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera.cameraMatrix(), camera.distortion(), projected);
  int compared = 0;
  double worst = 0.0;
  double largest_distortion = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Rect2d whole(16.0, 16.0, 608.0, 448.0);
    if (!whole.contains(projected[i])) continue;
    const cv::Point2d seen = centroidNear(image, projected[i]);
    worst = std::max(worst, cv::norm(seen - projected[i]));
    const cv::Matx33d k = camera.cameraMatrix();
    const cv::Point2d pinhole(k(0, 2) + k(0, 0) * points[i].x / points[i].z,
                              k(1, 2) + k(1, 1) * points[i].y / points[i].z);
    largest_distortion = std::max(largest_distortion, cv::norm(pinhole - projected[i]));
    ++compared;
  }
  EXPECT_GE(compared, 50);
  EXPECT_GT(largest_distortion, 4.0) << "the test must have distortion to find";
  // A mark is 10 px wide: a row's edges are known to 0.3 px each, the centroid of ten rows to 0.1.
  EXPECT_LT(worst, 0.3);
}

TEST(Camera, RefusesADistortionThatFoldsTheImage) {
  CameraParams params;
  params.k1 = -1.0;
  EXPECT_THROW(Camera(params, 1), ConfigError);
}

TEST(Camera, SignalFollowsIlluminanceExactly) {
  const BoxScene world = floorOf({1, 1, 1});
  const RayTracer tracer(world.scene);
  for (const double lx : {100.0, 400.0, 1500.0}) {
    const Lighting lighting(lit(lx), tracer, 1);
    Camera camera(plain(), 1);
    const cv::Mat image = renderStill(camera, tracer, lighting, lookDown(0, 0, 2)).bgr;
    // electrons / full well = lx * 1200 / (lx s) * 0.005 s / 12000; a byte of sRGB is up to 2 % of such a
    // level.
    const double expected = lx * 1200.0 * 0.005 / 12000.0;
    EXPECT_NEAR(linearOf(meanOf(image, kCentre)), expected, 0.02 * expected) << lx << " lx";
  }
}

TEST(Camera, ExposureHoldsTheSignalUntilItIsLongest) {
  const BoxScene world = floorOf({0.6F, 0.6F, 0.6F});
  const RayTracer tracer(world.scene);
  CameraParams params;
  params.gain_limit = 2.0;
  const auto settledMean = [&](double lx) {
    Camera camera(params, 1);
    const cv::Mat image =
        renderStill(camera, tracer, Lighting(lit(lx), tracer, 1), lookDown(0, 0, 2), 10).bgr;
    return linearOf(meanOf(image, kCentre));
  };
  const double bright = settledMean(2000.0);
  EXPECT_NEAR(bright, params.exposure_target, 0.02);
  EXPECT_NEAR(settledMean(200.0), bright, 0.02);
  EXPECT_LT(settledMean(20.0), 0.5 * bright) << "longest exposure and gain are not enough";
}

TEST(Camera, ExposureLengthensBeforeTheGainRises) {
  const BoxScene world = floorOf({0.6F, 0.6F, 0.6F});
  const RayTracer tracer(world.scene);
  Camera bright(CameraParams{}, 1);
  renderStill(bright, tracer, Lighting(lit(800.0), tracer, 1), lookDown(0, 0, 2), 8);
  EXPECT_LT(bright.exposureTime_s(), CameraParams{}.longest_exposure_s);
  EXPECT_EQ(bright.gain(), 1.0);
  Camera dim(CameraParams{}, 1);
  renderStill(dim, tracer, Lighting(lit(30.0), tracer, 1), lookDown(0, 0, 2), 8);
  EXPECT_EQ(dim.exposureTime_s(), CameraParams{}.longest_exposure_s);
  EXPECT_GT(dim.gain(), 1.5);
}

TEST(Camera, DimImageIsNoisierThanTubeLit) {
  const BoxScene world = floorOf({0.6F, 0.6F, 0.6F});
  const RayTracer tracer(world.scene);
  const auto relativeNoise = [&](const char* setting) {
    LightingParams light;
    light.setting = setting;
    Camera camera(CameraParams{}, 1);
    const cv::Mat image = renderStill(camera, tracer, Lighting(light, tracer, 1), lookDown(0, 0, 2), 10).bgr;
    return deviationOf(image, kCentre) / meanOf(image, kCentre);
  };
  EXPECT_GT(relativeNoise("dim"), 1.5 * relativeNoise("tube"));
}

TEST(Camera, ShotNoiseIsTheRootOfTheElectrons) {
  const BoxScene world = floorOf({1, 1, 1});
  const RayTracer tracer(world.scene);
  CameraParams params = plain();
  params.shot_noise = true;
  const Lighting lighting(lit(400.0), tracer, 1);
  Camera camera(params, 1);
  const cv::Mat image = renderStill(camera, tracer, lighting, lookDown(0, 0, 2)).bgr;
  cv::Mat linear(1, kCentre.area(), CV_64F);
  for (int i = 0; i < kCentre.area(); ++i) {
    const auto byte = image.at<cv::Vec3b>(kCentre.y + i / kCentre.width, kCentre.x + i % kCentre.width)[1];
    linear.at<double>(i) = 12000.0 * linearOf(byte);
  }
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(linear, mean, deviation);
  // 2400 electrons have a deviation of 49; a byte is 60 electrons here, whose rounding adds 60 / sqrt(12) in
  // quadrature. n = 6400: standard error 0.9 %; 4 of them.
  const double byte_e = 12000.0 * (linearOf(124.5) - linearOf(123.5));
  EXPECT_NEAR(deviation[0], std::sqrt(2400.0 + byte_e * byte_e / 12.0), 0.036 * 52.0 + 1.0);
}

TEST(Camera, ShadowIsDarkerThanWhatIsLit) {
  BoxScene world = floorOf({0.8F, 0.8F, 0.8F});
  world.addBox({1.0F, 1.0F, 0.1F}, at(0.0, 0.0, 1.0), world.addMaterial({0.8F, 0.8F, 0.8F}));
  world.scene.lights[0].direction = Eigen::Vector3d(1.0, 0.0, -1.0).normalized();
  world.scene.ambient.setConstant(0.2F);
  const RayTracer tracer(world.scene);
  Camera camera(plain(), 1);
  // Looking down from beside the slab: its shadow lies 1 m along x from it, below the camera.
  const Eigen::Isometry3d pose = lookDown(1.2, 0, 3);
  const cv::Mat image = renderStill(camera, tracer, Lighting(lit(800.0), tracer, 1), pose).bgr;
  const double focal = camera.cameraMatrix()(0, 0);
  const int shadow_column = cvRound(319.5 + focal * (1.1 - 1.2) / 3.0);
  const int lit_row = cvRound(239.5 + focal * 1.0 / 3.0);
  const double shadow = linearOf(meanOf(image, {shadow_column, 235, 10, 10}));
  const double sunlit = linearOf(meanOf(image, {shadow_column, lit_row, 10, 10}));
  // Under the sun 1 / sqrt(2) and the ambient 0.2 come together, in the shadow the ambient alone.
  EXPECT_NEAR(shadow / sunlit, 0.2 / (0.2 + M_SQRT1_2), 0.02);
}

/// How the edge between a black wall and a white one rises along the middle row.
struct Edge {
  int width_px = 0;           // columns between 5 % and 95 % of the white
  double largest_step = 0.0;  // between neighbouring columns, as a share of the white
};

Edge edgeIn(const cv::Mat& bgr) {
  const double white = linearOf(bgr.at<cv::Vec3b>(240, bgr.cols - 1)[1]);
  Edge edge;
  double before = 0.0;
  for (int column = 0; column < bgr.cols; ++column) {
    const double share = linearOf(bgr.at<cv::Vec3b>(240, column)[1]) / white;
    if (share > 0.05 && share < 0.95) ++edge.width_px;
    edge.largest_step = std::max(edge.largest_step, std::abs(share - before));
    before = share;
  }
  return edge;
}

TEST(Camera, MotionWhileTheShutterIsOpenBlursEdges) {
  BoxScene world;
  world.scene.ambient.setConstant(1.0F);
  world.addBox({0.1F, 10.0F, 10.0F}, at(3.0, 5.0, 0.0), world.addMaterial({0, 0, 0}));
  world.addBox({0.1F, 10.0F, 10.0F}, at(3.0, -5.0, 0.0), world.addMaterial({1, 1, 1}));
  const RayTracer tracer(world.scene);
  const Lighting lighting(lit(800.0), tracer, 1);
  const Eigen::Isometry3d open = lookAlongX(0, 0, 0);
  Eigen::Isometry3d close = open;
  close.rotate(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitY()));
  for (const bool blur : {false, true}) {
    CameraParams params = plain();
    params.motion_blur = blur;
    Camera camera(params, 1);
    const Edge edge = edgeIn(camera.render(tracer, lighting, open, close, Stamp{}).bgr);
    if (blur) {
      EXPECT_NEAR(edge.width_px, 0.9 * 16.0, 2.0) << "0.03 rad are 16 px";
      // An even ramp over 16 px rises by 1/16 a column; ghosts would rise by 1/3.
      EXPECT_LT(edge.largest_step, 2.0 / 16.0);
    } else {
      EXPECT_LE(edge.width_px, 1);
    }
  }
}

TEST(Camera, SameSeedGivesTheSameBytesOnAnyNumberOfThreads) {
  BoxScene world = floorOf({0.8F, 0.5F, 0.3F});
  world.addBox({0.5F, 0.5F, 0.5F}, at(2.0, 0.3, 0.25), world.addMaterial({0.2F, 0.4F, 0.9F}));
  const RayTracer tracer(world.scene);
  const Lighting lighting(LightingParams{}, tracer, 9);
  const auto run = [&](int threads, std::uint64_t seed) {
    CameraParams params;
    params.threads = threads;
    Camera camera(params, seed);
    cv::Mat image;
    for (int i = 0; i < 3; ++i) {
      image =
          camera.render(tracer, lighting, lookAlongX(0, 0, 0.4), lookAlongX(0.02, 0.01, 0.4), Stamp{}).bgr;
    }
    return image;
  };
  const cv::Mat one = run(1, 7);
  const cv::Mat two = run(2, 7);
  const cv::Mat other = run(2, 8);
  EXPECT_EQ(cv::norm(one, two, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(one, other, cv::NORM_INF), 0.0);
}

TEST(Camera, FarTexturesAreAveragedNotAliased) {
  BoxScene world;
  Texture checks{"checks", 64, 64, {}};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) checks.rgb.insert(checks.rgb.end(), 3, (x / 32 + y / 32) % 2 == 0 ? 255 : 0);
  }
  world.scene.textures.push_back(checks);
  Material material;
  material.albedo.setOnes();
  material.texture = 0;
  world.scene.materials.push_back(material);
  Mesh ground;
  ground.vertices = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
  ground.uvs = {{0, 0}, {500, 0}, {500, 500}, {0, 500}};
  ground.triangles = {{0, 1, 2}, {0, 2, 3}};
  ground.triangle_material = {0, 0};
  world.scene.meshes.push_back(ground);
  Model model;
  model.visuals.push_back({0, Eigen::Isometry3d::Identity()});
  world.scene.models.push_back(model);
  world.addSun({0.0, 0.0, -1.0});
  const RayTracer tracer(world.scene);
  Camera camera(plain(), 1);
  const cv::Mat image = renderStill(camera, tracer, Lighting(lit(800.0), tracer, 1), lookDown(0, 0, 40)).bgr;
  // A pixel covers 75 mm of checks 100 mm wide, in pairs of 200 mm: most of the contrast must be gone.
  const double mean = meanOf(image, kCentre);
  EXPECT_NEAR(linearOf(mean), 0.5 * 800.0 * 1200.0 * 0.005 / 12000.0, 0.03);
  const cv::Mat farther =
      renderStill(camera, tracer, Lighting(lit(800.0), tracer, 1), lookDown(0, 0, 80)).bgr;
  EXPECT_LT(deviationOf(farther, kCentre), 12.0);
}

TEST(Camera, ProfileHoldsTheDefaults) {
  const std::string path = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/sensors/rpi_camera.yaml";
  EXPECT_EQ(toYaml(loadParamFile<CameraParams>(path)), toYaml(CameraParams{}));
  EXPECT_EQ(readParamFile(path).size(), describe(CameraParams{}).size()) << "every key stands in the file";
}

TEST(Camera, MovedModelLooksAsIfBuiltThere) {
  BoxScene world = floorOf({0.8F, 0.8F, 0.8F});
  const int box = world.addBox({0.4F, 0.6F, 0.8F}, at(0.0, 0.0, -5.0), world.addMaterial({0.2F, 0.4F, 0.9F}));
  world.scene.lights[0].direction = Eigen::Vector3d(1.0, 0.4, -0.8).normalized();
  RayTracer moved(world.scene);
  Eigen::Isometry3d pose = at(2.0, 0.1, 0.5);
  pose.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, 0.2, 1.0).normalized()));
  world.scene.models[static_cast<std::size_t>(box)].world_from_model = pose;
  moved.updateModel(box);
  moved.commit();
  const RayTracer built(world.scene);
  cv::Mat images[2];
  for (const bool is_moved : {false, true}) {
    const RayTracer& tracer = is_moved ? moved : built;
    const Lighting lighting(lit(600.0), tracer, 1);
    Camera camera(plain(), 1);
    images[is_moved ? 1 : 0] = renderStill(camera, tracer, lighting, lookAlongX(0, 0, 0.4)).bgr;
  }
  cv::Mat difference;
  cv::absdiff(images[0], images[1], difference);
  // Only pixels on an edge may fall to its other side by rounding.
  EXPECT_LT(cv::countNonZero(difference.reshape(1) > 1), 30);
}

}  // namespace
}  // namespace frugal_nav::sim
