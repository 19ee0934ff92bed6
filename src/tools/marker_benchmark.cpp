// One image's markers found, and the robot placed by them; a step of the filter.

#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/localization/pose_ekf.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>
#include <frugal_nav/perception/marker_localizer.hpp>

namespace frugal_nav {
namespace {

constexpr double kDepth_m = 2.0;

Pinhole camera() {
  Pinhole pinhole;
  pinhole.width_px = 640;
  pinhole.height_px = 480;
  pinhole.fx = pinhole.fy = 530.0;
  pinhole.cx = 319.5;
  pinhole.cy = 239.5;
  return pinhole;
}

/// Four markers of 0.2 m on a wall two metres ahead of a camera in the map's origin.
MarkerMap wall() {
  MarkerMap map;
  int id = 0;
  for (const double y_m : {0.7, -0.7}) {
    for (const double z_m : {0.4, -0.4}) {
      MappedMarker marker;
      marker.id = id;
      marker.size_m = 0.2;
      marker.map_from_marker.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;
      marker.map_from_marker.translation() = Eigen::Vector3d(kDepth_m, y_m, z_m);
      map.markers[id++] = marker;
    }
  }
  return map;
}

Eigen::Isometry3d baseFromOptical() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return pose;
}

/// What that camera sees, on a wall with noise and 40 boxes that are no markers.
cv::Mat picture(const MarkerMap& map) {
  constexpr double kWhiteShare = 1.4;
  const Pinhole pinhole = camera();
  Random random(500001);
  cv::Mat image(pinhole.height_px, pinhole.width_px, CV_8UC1, cv::Scalar(120));
  for (int i = 0; i < 40; ++i) {
    const cv::Rect box(random.integer(0, 600), random.integer(0, 440), random.integer(8, 80),
                       random.integer(8, 80));
    cv::rectangle(image, box, cv::Scalar(random.integer(40, 200)), cv::FILLED);
  }
  const MarkerDictionary dictionary(map.dictionary);
  for (const auto& [id, marker] : map.markers) {
    const Eigen::Vector3d p = baseFromOptical().inverse() * marker.map_from_marker.translation();
    const Eigen::Vector2d middle = *pinhole.project(p);
    const int side = static_cast<int>(pinhole.fx * marker.size_m / kDepth_m);
    const auto square = [&middle](int size) {
      return cv::Rect(static_cast<int>(middle.x()) - size / 2, static_cast<int>(middle.y()) - size / 2, size,
                      size);
    };
    cv::rectangle(image, square(static_cast<int>(kWhiteShare * side)), cv::Scalar(210), cv::FILLED);
    cv::Mat print;
    cv::resize(dictionary.cellsOf(id), print, {side, side}, 0, 0, cv::INTER_NEAREST);
    print.copyTo(image(square(side)));
  }
  cv::GaussianBlur(image, image, {0, 0}, 0.7);
  for (int i = 0; i < image.rows * image.cols; ++i) {
    unsigned char& grey = image.data[i];
    grey = cv::saturate_cast<unsigned char>(grey + random.normal(4.0));
  }
  return image;
}

/// 640x480 with four markers, from the image to the robot's pose.
void markerFix(benchmark::State& state) {
  const MarkerMap map = wall();
  const cv::Mat image = picture(map);
  const MarkerDetector detector{MarkerDetectorParams()};
  const MarkerLocalizer localizer(MarkerLocalizerParams(), map, camera(), baseFromOptical());
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  double used = 0.0;
  for (auto _ : state) {
    const MarkerFix fix = localizer.locate(detector.detect(image).markers);
    used = fix.isGood() ? static_cast<double>(fix.sightings.size()) : 0.0;
  }
  cv::setNumThreads(threads);
  state.counters["markers"] = used;
  state.counters["images_per_s"] = benchmark::Counter(1.0, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(markerFix)->Unit(benchmark::kMillisecond);

/// A prediction over 20 ms by wheels and gyro and a correction by a pose.
void poseFilterStep(benchmark::State& state) {
  const PoseEkf ekf{PoseFilterParams()};
  constexpr Duration kPeriod = std::chrono::milliseconds(20);
  const Twist2 twist{0.3, 0.2};
  Stamp stamp{kPeriod};
  const Eigen::Vector3d sigmas(0.02, 0.02, 0.01);
  PoseFix fix{{}, sigmas.cwiseAbs2().asDiagonal()};
  EkfState filter = ekf.withPose(ekf.initial(stamp), stamp, fix).state;
  for (auto _ : state) {
    stamp += kPeriod;
    fix.map_from_base = fix.map_from_base * arcMotion(twist, toSeconds(kPeriod));
    filter.gyro_radps = HeldInput<double>{stamp, twist.w_radps};
    filter = ekf.withTwist(filter, stamp, twist);
    filter = ekf.withPose(filter, stamp, fix).state;
    benchmark::DoNotOptimize(filter);
  }
}
BENCHMARK(poseFilterStep)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace frugal_nav
