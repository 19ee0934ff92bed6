#include "as_printed_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>

#include <frugal_nav/perception/marker_dictionary.hpp>

namespace frugal_nav::eval {
namespace {

double areaOf(const MarkerCorners& marker) {
  const Eigen::Vector2d a = marker.pixels[2] - marker.pixels[0];
  const Eigen::Vector2d b = marker.pixels[3] - marker.pixels[1];
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

}  // namespace

std::vector<MarkerCorners> detectAsPrinted(const cv::Mat& image, const std::string& dictionary) {
  std::vector<std::vector<cv::Point2f>> quads;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(MarkerDictionary(dictionary).index()),
                           quads, ids);
  std::vector<MarkerCorners> markers;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MarkerCorners& marker = markers.emplace_back();
    marker.id = ids[i];
    for (std::size_t k = 0; k < 4; ++k) marker.pixels[k] = {quads[i][k].x, quads[i][k].y};
  }
  return markers;
}

AsPrintedFilter::AsPrintedFilter(const AsPrintedParams& params, MarkerMap map, const Pinhole& camera,
                                 const Eigen::Isometry3d& base_from_optical, const Pose2& map_from_base)
    : params_(params),
      map_(std::move(map)),
      camera_(camera),
      base_from_optical_(base_from_optical),
      map_from_base_(map_from_base),
      imu_yaw_rad_(map_from_base.yaw_rad) {
  validate(params_, "as_printed");
}

void AsPrintedFilter::addGyro(Stamp stamp, double rate_radps) {
  if (last_gyro_) imu_yaw_rad_ = wrapAngle(imu_yaw_rad_ + rate_radps * toSeconds(stamp - *last_gyro_));
  last_gyro_ = stamp;
}

void AsPrintedFilter::predict(Stamp stamp, double commanded_mps) {
  const double way_m = last_prediction_ ? commanded_mps * toSeconds(stamp - *last_prediction_) : 0.0;
  last_prediction_ = stamp;
  const double c = std::cos(map_from_base_.yaw_rad);
  const double s = std::sin(map_from_base_.yaw_rad);
  Eigen::Matrix3d by_state = Eigen::Matrix3d::Identity();
  by_state(0, 2) = -way_m * s;
  by_state(1, 2) = way_m * c;
  const Eigen::Vector3d sigmas(params_.process_sigma_m, params_.process_sigma_m, params_.process_sigma_rad);
  covariance_ = by_state * covariance_ * by_state.transpose();
  covariance_.diagonal() += sigmas.cwiseAbs2();
  map_from_base_ = {map_from_base_.x_m + way_m * c, map_from_base_.y_m + way_m * s, imu_yaw_rad_};
}

void AsPrintedFilter::correct(const std::vector<MarkerCorners>& markers) {
  const auto largest =
      std::max_element(markers.begin(), markers.end(),
                       [](const MarkerCorners& a, const MarkerCorners& b) { return areaOf(a) < areaOf(b); });
  if (largest == markers.end()) return;
  const std::optional<Pose2> measured = measure(*largest);
  if (!measured) return;
  const Eigen::Vector3d sigmas(params_.marker_sigma_m, params_.marker_sigma_m, params_.marker_sigma_rad);
  const Eigen::Matrix3d noise = sigmas.cwiseAbs2().asDiagonal();
  const Eigen::Matrix3d gain = covariance_ * (covariance_ + noise).inverse();
  const Eigen::Vector3d step =
      gain * Eigen::Vector3d(measured->x_m - map_from_base_.x_m, measured->y_m - map_from_base_.y_m,
                             angleBetween(map_from_base_.yaw_rad, measured->yaw_rad));
  map_from_base_ = {map_from_base_.x_m + step.x(), map_from_base_.y_m + step.y(),
                    wrapAngle(map_from_base_.yaw_rad + step.z())};
  covariance_ = (Eigen::Matrix3d::Identity() - gain) * covariance_;
}

/// The pose that one marker gives (sections 3.3 and 4.1); nothing when its corners fit badly or it seems too
/// far.
std::optional<Pose2> AsPrintedFilter::measure(const MarkerCorners& corners) const {
  const auto mapped = map_.markers.find(corners.id);
  if (mapped == map_.markers.end()) return std::nullopt;
  std::vector<cv::Point3d> square;
  std::vector<cv::Point2d> pixels;
  for (const Eigen::Vector3d& p : markerCorners(mapped->second.size_m))
    square.emplace_back(p.x(), p.y(), p.z());
  for (const Eigen::Vector2d& p : corners.pixels) pixels.emplace_back(p.x(), p.y());
  const cv::Matx33d matrix(camera_.fx, 0.0, camera_.cx, 0.0, camera_.fy, camera_.cy, 0.0, 0.0, 1.0);
  const cv::Vec<double, 5> lens(camera_.k1, camera_.k2, camera_.p1, camera_.p2, camera_.k3);
  cv::Vec3d turn;
  cv::Vec3d shift;
  if (!cv::solvePnP(square, pixels, matrix, lens, turn, shift) || cv::norm(shift) > params_.max_range_m)
    return std::nullopt;
  std::vector<cv::Point2d> expected;
  cv::projectPoints(square, turn, shift, matrix, lens, expected);
  double error_px = 0.0;
  for (std::size_t i = 0; i < 4; ++i) error_px += 0.25 * cv::norm(pixels[i] - expected[i]);
  if (error_px > params_.max_image_error_px) return std::nullopt;

  cv::Matx33d rotation;
  cv::Rodrigues(turn, rotation);
  Eigen::Isometry3d optical_from_marker = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    optical_from_marker.translation()[row] = shift[row];
    for (int column = 0; column < 3; ++column)
      optical_from_marker.linear()(row, column) = rotation(row, column);
  }
  return toPose2(mapped->second.map_from_marker * (base_from_optical_ * optical_from_marker).inverse());
}

}  // namespace frugal_nav::eval
