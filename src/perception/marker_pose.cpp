#include "marker_fit.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

#include <frugal_nav/perception/marker_map.hpp>
#include <frugal_nav/perception/marker_pose.hpp>

namespace frugal_nav {
namespace {

using marker_detail::imageError;
using marker_detail::PointJacobian;
using marker_detail::PoseFit;
using marker_detail::Residuals;

constexpr double kRadFromDeg = M_PI / 180.0;

Residuals cornerResiduals(const Pinhole& camera, const MarkerCorners& corners, double size_m, double sigma_px,
                          const Eigen::Isometry3d& camera_from_marker) {
  Residuals residuals;
  const auto points = markerCorners(size_m);
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d turned = camera_from_marker.linear() * points[i];
    PointJacobian jacobian;
    jacobian << Eigen::Matrix3d::Identity(), -marker_detail::crossMatrix(turned);
    marker_detail::addCorner(camera, turned + camera_from_marker.translation(), jacobian, corners.pixels[i],
                             sigma_px, residuals);
  }
  return residuals;
}

/// Directions in which the corners are seen, at z = 1; empty when the lens shows nothing there.
std::vector<cv::Point2d> flatCorners(const Pinhole& camera, const MarkerCorners& corners) {
  std::vector<cv::Point2d> flat;
  for (const Eigen::Vector2d& pixel : corners.pixels) {
    const auto look = pixel.allFinite() ? camera.lookThrough(pixel) : std::nullopt;
    if (!look) return {};
    flat.emplace_back(look->point.x(), look->point.y());
  }
  return flat;
}

/// The two poses that IPPE gives; none when the corners are not a square's.
std::vector<Eigen::Isometry3d> solveSquare(const std::vector<cv::Point2d>& flat, double size_m) {
  // IPPE divides by the distance of the marker's centre from the optical axis: it is given a view by a camera
  // that is turned so that every centre lies in the same place beside the axis.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const cv::Point2d& p : flat) centre += Eigen::Vector3d(p.x, p.y, 1.0);
  const Eigen::Quaterniond turned_from_camera =
      Eigen::Quaterniond::FromTwoVectors(centre, Eigen::Vector3d(0.1, 0.05, 1.0));
  std::vector<cv::Point2d> turned;
  for (const cv::Point2d& p : flat) {
    const Eigen::Vector3d ray = turned_from_camera * Eigen::Vector3d(p.x, p.y, 1.0);
    if (ray.z() <= 0.0) return {};
    turned.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
  }
  std::vector<cv::Point3d> square;
  for (const Eigen::Vector3d& p : markerCorners(size_m)) square.emplace_back(p.x(), p.y(), p.z());
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::solvePnPGeneric(square, turned, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations, translations,
                        false, cv::SOLVEPNP_IPPE_SQUARE);
  } catch (const cv::Exception&) {  // corners on one line
    return {};
  }
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::Matx33d rotation;
    cv::Rodrigues(rotations[i], rotation);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row) {
      pose.translation()[row] = translations[i].at<double>(row);
      for (int column = 0; column < 3; ++column) pose.linear()(row, column) = rotation(row, column);
    }
    if (pose.matrix().allFinite()) poses.push_back(Eigen::Isometry3d(turned_from_camera.conjugate()) * pose);
  }
  return poses;
}

/// The same, also for a marker turned exactly about one of its axes: there IPPE may take the root of a
/// rounding error below zero, and has a solution for corners a millionth off.
std::vector<Eigen::Isometry3d> startPoses(const std::vector<cv::Point2d>& flat, double size_m) {
  std::vector<Eigen::Isometry3d> poses = solveSquare(flat, size_m);
  if (poses.size() > 1) return poses;
  const double nudge = 1e-6 * cv::norm(flat[2] - flat[0]);
  std::vector<cv::Point2d> nudged = flat;
  nudged[0] += cv::Point2d(nudge, 0.3 * nudge);
  nudged[1] += cv::Point2d(-0.2 * nudge, 0.7 * nudge);
  return solveSquare(nudged, size_m);
}

double angleApart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

/// Mean distance of the corners from where they are, on the marker's plane.
double objectError(const std::vector<cv::Point2d>& flat, double size_m,
                   const Eigen::Isometry3d& camera_from_marker) {
  const Eigen::Isometry3d marker_from_camera = camera_from_marker.inverse();
  const auto points = markerCorners(size_m);
  double sum_m = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d eye = marker_from_camera.translation();
    const Eigen::Vector3d ray = marker_from_camera.linear() * Eigen::Vector3d(flat[i].x, flat[i].y, 1.0);
    sum_m += (eye - ray * (eye.z() / ray.z()) - points[i]).norm();
  }
  return sum_m / 4.0;
}

double shortestSide(const MarkerCorners& corners) {
  double side_px = (corners.pixels[0] - corners.pixels[3]).norm();
  for (std::size_t i = 0; i < 3; ++i)
    side_px = std::min(side_px, (corners.pixels[i] - corners.pixels[i + 1]).norm());
  return side_px;
}

/// Between the line of sight and the marker's normal [rad]; more than a right angle is its back.
double viewAngle(const Eigen::Isometry3d& camera_from_marker) {
  const Eigen::Vector3d to_camera = -camera_from_marker.translation().normalized();
  return std::acos(std::clamp(to_camera.dot(camera_from_marker.linear().col(2)), -1.0, 1.0));
}

}  // namespace

const char* toText(MarkerPose::Status status) {
  switch (status) {
    case MarkerPose::Status::kGood:
      return "good";
    case MarkerPose::Status::kNoSolution:
      return "its corners are no square seen by this camera";
    case MarkerPose::Status::kNoEdges:
      return "its edges cannot be made out";
    case MarkerPose::Status::kTooSmall:
      return "too small in the image";
    case MarkerPose::Status::kTooNear:
      return "implausibly near";
    case MarkerPose::Status::kTooFar:
      return "too far";
    case MarkerPose::Status::kTooOblique:
      return "seen too much from the side";
    case MarkerPose::Status::kLargeError:
      return "its corners do not fit its pose";
    case MarkerPose::Status::kAmbiguous:
      return "two poses fit alike";
  }
  return "unknown";
}

MarkerPoseEstimator::MarkerPoseEstimator(const MarkerPoseParams& params, const Pinhole& camera)
    : params_(params), camera_(camera) {
  validate(params, "marker pose");
  const std::string fault = camera.fault();
  if (!fault.empty()) throw ConfigError("marker pose: " + fault);
}

MarkerPose MarkerPoseEstimator::estimate(const MarkerCorners& corners, double size_m,
                                         const std::optional<Eigen::Isometry3d>& predicted) const {
  MarkerPose pose;
  pose.id = corners.id;
  if (!corners.has_edges) {
    pose.status = MarkerPose::Status::kNoEdges;
    return pose;
  }
  const std::vector<cv::Point2d> flat = flatCorners(camera_, corners);
  if (flat.empty() || !(size_m > 0.0)) return pose;
  const auto evaluate = [&](const Eigen::Isometry3d& camera_from_marker) {
    return cornerResiduals(camera_, corners, size_m, params_.sigmaOf_px(corners), camera_from_marker);
  };
  for (const Eigen::Isometry3d& start : startPoses(flat, size_m)) {
    // A flipped solution need not be a minimum in pixels: then it is kept as it came.
    PoseFit fit = marker_detail::fitPose(start, evaluate);
    if (!fit.residuals.valid) continue;
    const bool same = !pose.solutions.empty() &&
                      angleApart(fit.pose, pose.solutions.front().camera_from_marker) < 0.2 * kRadFromDeg;
    const Eigen::Isometry3d& kept = same ? start : fit.pose;
    pose.solutions.push_back({kept, imageError(camera_, corners, size_m, kept)});
  }
  if (pose.solutions.empty()) return pose;
  chooseSolution(params_.sigmaOf_px(corners), predicted, pose);
  const Eigen::Isometry3d& chosen = pose.solutions.front().camera_from_marker;
  pose.range_m = chosen.translation().norm();
  pose.object_error_m = objectError(flat, size_m, chosen);
  pose.covariance = evaluate(chosen).information.ldlt().solve(Matrix6d::Identity());
  if (!pose.covariance.allFinite()) {
    pose.status = MarkerPose::Status::kNoSolution;
    return pose;
  }
  judge(corners, pose);
  return pose;
}

void MarkerPoseEstimator::chooseSolution(double sigma_px, const std::optional<Eigen::Isometry3d>& predicted,
                                         MarkerPose& pose) const {
  pose.status = MarkerPose::Status::kGood;
  if (pose.solutions.size() < 2) return;
  MarkerSolution& better = pose.solutions[0];
  MarkerSolution& worse = pose.solutions[1];
  if (worse.image_error_px < better.image_error_px) std::swap(better, worse);
  pose.error_ratio = worse.image_error_px / std::max(better.image_error_px, sigma_px);
  if (pose.error_ratio >= params_.flip_ratio) return;
  const double apart = angleApart(better.camera_from_marker, worse.camera_from_marker);
  if (apart <= params_.same_pose_deg * kRadFromDeg) return;
  pose.status = MarkerPose::Status::kAmbiguous;
  if (!predicted || !predicted->matrix().allFinite()) return;
  const double better_off = angleApart(*predicted, better.camera_from_marker);
  const double worse_off = angleApart(*predicted, worse.camera_from_marker);
  if (std::min(better_off, worse_off) > params_.max_prediction_error_deg * kRadFromDeg) return;
  // The prediction must be clearly nearer to one of them, not halfway between.
  if (std::abs(better_off - worse_off) < 0.5 * apart) return;
  if (worse_off < better_off) std::swap(better, worse);
  pose.status = MarkerPose::Status::kGood;
}

void MarkerPoseEstimator::judge(const MarkerCorners& corners, MarkerPose& pose) const {
  using Status = MarkerPose::Status;
  const MarkerSolution& chosen = pose.solutions.front();
  if (shortestSide(corners) < params_.min_side_px) {
    pose.status = Status::kTooSmall;
  } else if (pose.range_m < params_.min_range_m) {
    pose.status = Status::kTooNear;
  } else if (pose.range_m > params_.max_range_m) {
    pose.status = Status::kTooFar;
  } else if (chosen.image_error_px > params_.max_image_error_px) {
    pose.status = Status::kLargeError;
  } else if (viewAngle(chosen.camera_from_marker) > params_.max_view_angle_deg * kRadFromDeg) {
    pose.status = Status::kTooOblique;
  }
}

}  // namespace frugal_nav
