// Visual odometry on a real hand-held recording: images and, for the scale alone, the true distances.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <frugal_nav/eval/trajectory_metrics.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav::eval {
namespace {

/// FRUGAL_NAV_DATA, or ../shared/data beside the source tree.
std::string officeFolder() {
  const char* given = std::getenv("FRUGAL_NAV_DATA");
  const std::string folder = given != nullptr ? given : FRUGAL_NAV_SOURCE_DIR "/../shared/data";
  return folder + "/rgbd_office/";
}

std::vector<Eigen::Isometry3d> readPoses(const std::string& path) {
  std::ifstream file(path);
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Matrix4d m;
  for (;;) {
    for (int i = 0; i < 16; ++i) file >> m(i / 4, i % 4);
    if (!file) return poses;
    poses.emplace_back(m);
  }
}

Pinhole readCamera(const std::string& path, const cv::Size& size) {
  std::ifstream file(path);
  double k[9];
  for (double& value : k) file >> value;
  return {size.width, size.height, k[0], k[4], k[2], k[5], 0.0, 0.0, 0.0, 0.0, 0.0};
}

class RgbdOffice : public testing::TestWithParam<const char*> {};

TEST_P(RgbdOffice, TracksMostOfTheHandHeldWalk) {
  const std::string folder = officeFolder();
  if (!std::filesystem::exists(folder + "poses.txt")) GTEST_SKIP() << "no recording at " << folder;
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "images"))
    names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  const std::vector<Eigen::Isometry3d> truth = readPoses(folder + "poses.txt");
  ASSERT_EQ(names.size(), truth.size());

  VisualOdometryParams params;
  params.features.method = GetParam();
  params.motion.wheels = "scale";  // turns and courses of the truth are not used
  params.motion.planar = false;
  VisualOdometry odometry(params, readCamera(folder + "K.txt", cv::imread(names[0]).size()),
                          Eigen::Isometry3d::Identity());
  std::vector<PosePair> pairs;
  std::clock_t spent = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    VisualInput input;
    input.stamp = stampFromSeconds(0.1 * static_cast<double>(i) + 1.0);
    input.image = cv::imread(names[i]);
    input.odom_from_base = truth[i];
    const std::clock_t begin = std::clock();
    const VisualOdometryOutput output = odometry.process(input);
    spent += std::clock() - begin;
    if (output.status.state == VisualState::kTracking) pairs.push_back({truth[i], output.odom_from_camera});
  }
  const double share = static_cast<double>(pairs.size()) / static_cast<double>(names.size());
  const auto alignment = align(pairs, AlignmentKind::kSimilarity);
  ASSERT_TRUE(alignment);
  const ErrorStatistics ate = absoluteError(pairs, *alignment);
  double length_m = 0.0;
  for (std::size_t i = 1; i < truth.size(); ++i)
    length_m += (truth[i].translation() - truth[i - 1].translation()).norm();
  std::printf(
      "%s: tracked %.3f of %zu frames, way %.2f m, ATE after Sim(3) rmse %.4f m median %.4f m, scale %.4f, "
      "%.1f ms of processor time a frame\n",
      GetParam(), share, names.size(), length_m, ate.rmse, ate.median, alignment->scale,
      1000.0 * static_cast<double>(spent) / CLOCKS_PER_SEC / static_cast<double>(names.size()));
  EXPECT_GT(share, 0.5);
  EXPECT_LT(ate.rmse, 0.1 * length_m);
}

INSTANTIATE_TEST_SUITE_P(Methods, RgbdOffice, testing::Values("tracking", "matching"),
                         [](const auto& method) { return std::string(method.param); });

}  // namespace
}  // namespace frugal_nav::eval
