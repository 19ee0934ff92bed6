#include "marker_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <frugal_nav/perception/marker_localizer.hpp>

namespace frugal_nav {
namespace {

using marker_detail::PointJacobian;
using marker_detail::Residuals;
using Use = MarkerSighting::Use;

constexpr double kRadFromDeg = M_PI / 180.0;
constexpr int kCornerRows = 8;  // residuals of a marker
constexpr int kFloorRows = 3;
constexpr int kUnknowns = 6;

/// Covariance of (x, y, yaw) from that of (dt, dr). With c the first column of R, dc = dr x c, and
/// yaw = atan2(c_y, c_x): d yaw = dr_z - c_z (c_x dr_x + c_y dr_y) / (c_x^2 + c_y^2).
Eigen::Matrix3d planarCovariance(const Eigen::Isometry3d& pose, const Matrix6d& covariance) {
  const Eigen::Vector3d c = pose.linear().col(0);
  Eigen::Matrix<double, 3, 6> by_motion = Eigen::Matrix<double, 3, 6>::Zero();
  by_motion(0, 0) = by_motion(1, 1) = by_motion(2, 5) = 1.0;
  by_motion.block<1, 2>(2, 3) = -c.z() / c.head<2>().squaredNorm() * c.head<2>().transpose();
  return by_motion * covariance * by_motion.transpose();
}

bool isUsable(const MarkerPose& pose) {
  return pose.isGood() || pose.status == MarkerPose::Status::kAmbiguous;
}

std::vector<MarkerSighting>::iterator worstUsed(std::vector<MarkerSighting>& sightings,
                                                const std::vector<double>& errors_px) {
  auto worst = sightings.begin();
  double worst_px = -1.0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (sightings[i].use != Use::kUsed || errors_px[i] <= worst_px) continue;
    worst_px = errors_px[i];
    worst = sightings.begin() + static_cast<std::ptrdiff_t>(i);
  }
  return worst;
}

}  // namespace

struct MarkerLocalizer::Candidate {
  Eigen::Isometry3d map_from_base;
  Residuals residuals;
};

const char* toText(MarkerFix::Status status) {
  switch (status) {
    case MarkerFix::Status::kGood:
      return "good";
    case MarkerFix::Status::kNoMarker:
      return "no usable marker in view";
    case MarkerFix::Status::kAmbiguous:
      return "two places fit the markers alike";
    case MarkerFix::Status::kInconsistent:
      return "the markers contradict each other: check their places in the map";
    case MarkerFix::Status::kOffFloor:
      return "the robot would not stand on the floor: check the markers' sizes and places in the map";
  }
  return "unknown";
}

const char* toText(MarkerSighting::Use use) {
  switch (use) {
    case Use::kUsed:
      return "used";
    case Use::kUnmapped:
      return "not in the map";
    case Use::kTwice:
      return "its id is in the image more than once";
    case Use::kRefused:
      return "its pose is refused";
    case Use::kInconsistent:
      return "it contradicts the other markers";
  }
  return "unknown";
}

MarkerLocalizer::MarkerLocalizer(const MarkerLocalizerParams& params, MarkerMap map, const Pinhole& camera,
                                 const Eigen::Isometry3d& base_from_optical)
    : params_(params),
      map_(std::move(map)),
      estimator_(params.pose, camera),
      base_from_optical_(base_from_optical) {
  validate(params_, "marker localizer");
}

MarkerFix MarkerLocalizer::locate(const std::vector<MarkerCorners>& markers,
                                  const std::optional<Pose2>& predicted) const {
  if (predicted && !predicted->isFinite()) return locate(markers);
  MarkerFix fix;
  fix.sightings = inspect(markers, predicted);
  const auto countUsed = [&fix] {
    return static_cast<int>(std::count_if(fix.sightings.begin(), fix.sightings.end(),
                                          [](const MarkerSighting& s) { return s.use == Use::kUsed; }));
  };
  for (int used = countUsed(); used > 0; used = countUsed()) {
    std::vector<Candidate> candidates = fitAll(fix.sightings);
    if (candidates.empty()) return fix;
    fix.status = choose(predicted, used, candidates);
    const Candidate& best = candidates.front();
    std::vector<double> errors_px;
    double sum_px = 0.0;
    for (const MarkerSighting& sighting : fix.sightings) {
      errors_px.push_back(sighting.use == Use::kUsed ? imageError(sighting, best.map_from_base) : 0.0);
      sum_px += errors_px.back();
    }
    fix.map_from_base = toPose2(best.map_from_base);
    fix.covariance = planarCovariance(best.map_from_base, covarianceOf(fix.sightings, best));
    fix.image_error_px = sum_px / used;
    fix.alternative.reset();
    if (candidates.size() > 1) fix.alternative = toPose2(candidates[1].map_from_base);
    const auto worst = worstUsed(fix.sightings, errors_px);
    const auto worst_px = errors_px[static_cast<std::size_t>(worst - fix.sightings.begin())];
    if (worst_px <= params_.pose.max_image_error_px) {
      if (fix.isGood() && floorResidual(best.map_from_base).norm() > params_.max_floor_sigmas)
        fix.status = MarkerFix::Status::kOffFloor;
      return fix;
    }
    // Of three, two agree; of two, nobody knows which one is wrong.
    fix.status = used == 1 ? MarkerFix::Status::kOffFloor : MarkerFix::Status::kInconsistent;
    if (used < 3) return fix;
    worst->use = Use::kInconsistent;
  }
  return fix;
}

std::vector<MarkerSighting> MarkerLocalizer::inspect(const std::vector<MarkerCorners>& markers,
                                                     const std::optional<Pose2>& predicted) const {
  std::vector<MarkerSighting> sightings;
  for (const MarkerCorners& corners : markers) {
    MarkerSighting sighting;
    sighting.corners = corners;
    sighting.pose.id = corners.id;
    const auto mapped = map_.markers.find(corners.id);
    const auto same = std::count_if(markers.begin(), markers.end(),
                                    [&](const MarkerCorners& other) { return other.id == corners.id; });
    if (mapped == map_.markers.end()) {
      sighting.use = Use::kUnmapped;
    } else {
      std::optional<Eigen::Isometry3d> expected;
      if (predicted)
        expected = (toIsometry(*predicted) * base_from_optical_).inverse() * mapped->second.map_from_marker;
      sighting.pose = estimator_.estimate(corners, mapped->second.size_m, expected);
      sighting.use = same > 1 ? Use::kTwice : isUsable(sighting.pose) ? Use::kUsed : Use::kRefused;
    }
    sightings.push_back(std::move(sighting));
  }
  std::stable_sort(sightings.begin(), sightings.end(), [](const MarkerSighting& a, const MarkerSighting& b) {
    return a.corners.id < b.corners.id;
  });
  return sightings;
}

/// What the corners of a marker say against a pose of the robot.
void MarkerLocalizer::addMarker(const MarkerSighting& sighting, const Eigen::Isometry3d& map_from_base,
                                Residuals& residuals) const {
  const Eigen::Isometry3d optical_from_base = base_from_optical_.inverse();
  const Eigen::Matrix3d base_from_map = map_from_base.linear().transpose();
  const MappedMarker& marker = map_.markers.at(sighting.corners.id);
  const auto points = marker.corners();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d offset = marker.map_from_marker * points[i] - map_from_base.translation();
    PointJacobian jacobian;
    jacobian << -base_from_map, base_from_map * marker_detail::crossMatrix(offset);
    jacobian = optical_from_base.linear() * jacobian;
    marker_detail::addCorner(estimator_.camera(), optical_from_base * (base_from_map * offset), jacobian,
                             sighting.corners.pixels[i], params_.pose.sigmaOf_px(sighting.corners),
                             residuals);
  }
}

/// The floor: height, and the horizontal part of the robot's upward axis, which turns by dr x up.
void MarkerLocalizer::addFloor(const Eigen::Isometry3d& map_from_base, Residuals& residuals) const {
  const Eigen::Vector3d up = map_from_base.linear().col(2);
  Eigen::Matrix<double, kFloorRows, kUnknowns> by_motion;
  by_motion.setZero();
  by_motion(0, 2) = 1.0 / params_.height_sigma_m;
  by_motion.bottomRightCorner<2, 3>() =
      -marker_detail::crossMatrix(up).topRows<2>() / (params_.tilt_sigma_deg * kRadFromDeg);
  residuals.add<kFloorRows>(floorResidual(map_from_base), by_motion);
}

/// The distinct minima, the least cost first.
std::vector<MarkerLocalizer::Candidate> MarkerLocalizer::fitAll(
    const std::vector<MarkerSighting>& sightings) const {
  const auto evaluate = [&](const Eigen::Isometry3d& map_from_base) {
    Residuals residuals;
    for (const MarkerSighting& sighting : sightings) {
      if (sighting.use == Use::kUsed) addMarker(sighting, map_from_base, residuals);
    }
    addFloor(map_from_base, residuals);
    return residuals;
  };
  std::vector<Candidate> candidates;
  for (const MarkerSighting& sighting : sightings) {
    if (sighting.use != Use::kUsed) continue;
    for (const MarkerSolution& solution : sighting.pose.solutions) {
      const Eigen::Isometry3d start = map_.markers.at(sighting.corners.id).map_from_marker *
                                      solution.camera_from_marker.inverse() * base_from_optical_.inverse();
      const auto fit = marker_detail::fitPose(start, evaluate);
      const auto isSame = [&fit](const Candidate& other) {
        return Eigen::AngleAxisd(fit.pose.linear().transpose() * other.map_from_base.linear()).angle() <
               0.2 * kRadFromDeg;
      };
      if (fit.residuals.valid && std::none_of(candidates.begin(), candidates.end(), isSame))
        candidates.push_back({fit.pose, fit.residuals});
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.residuals.cost < b.residuals.cost; });
  return candidates;
}

/// Covariance of (dt, dr) by the corners' noise, which is at least what they show against the fit, and by the
/// places of the markers in the map. A marker that hangs turned by dr and shifted by dm about its centre c
/// moves the robot at b as its corners weigh in the fit: by (dm + dr x (b - c), dr).
Matrix6d MarkerLocalizer::covarianceOf(const std::vector<MarkerSighting>& sightings,
                                       const Candidate& best) const {
  const Matrix6d by_noise = best.residuals.information.ldlt().solve(Matrix6d::Identity());
  Eigen::Matrix<double, kUnknowns, 1> variances;
  variances << Eigen::Vector3d::Constant(std::pow(params_.map_sigma_m, 2)),
      Eigen::Vector3d::Constant(std::pow(params_.map_sigma_deg * kRadFromDeg, 2));
  Matrix6d by_map = Matrix6d::Zero();
  int freedom = kFloorRows - kUnknowns;
  for (const MarkerSighting& sighting : sightings) {
    if (sighting.use != Use::kUsed) continue;
    freedom += kCornerRows;
    Residuals own;
    addMarker(sighting, best.map_from_base, own);
    const Eigen::Vector3d offset =
        best.map_from_base.translation() - map_.markers.at(sighting.corners.id).map_from_marker.translation();
    Matrix6d by_place = Matrix6d::Identity();
    by_place.topRightCorner<3, 3>() = -marker_detail::crossMatrix(offset);
    const Matrix6d gain = by_noise * own.information * by_place;
    by_map += gain * variances.asDiagonal() * gain.transpose();
  }
  return std::max(1.0, best.residuals.cost / freedom) * by_noise + by_map;
}

/// Whether another place is as good as the first; it becomes the second. For one marker it is the rule of
/// MarkerPoseParams::flip_ratio; the difference it takes does not grow with the markers, as their evidence
/// adds up.
MarkerFix::Status MarkerLocalizer::choose(const std::optional<Pose2>& predicted, int markers_used,
                                          std::vector<Candidate>& candidates) const {
  const MarkerPoseParams& limits = params_.pose;
  Candidate& first = candidates[0];
  const double first_yaw = toPose2(first.map_from_base).yaw_rad;
  const auto yawApart = [first_yaw](const Candidate& other) {
    return std::abs(angleBetween(first_yaw, toPose2(other.map_from_base).yaw_rad));
  };
  const auto other = std::find_if(candidates.begin() + 1, candidates.end(), [&](const Candidate& candidate) {
    return yawApart(candidate) > limits.same_pose_deg * kRadFromDeg;
  });
  if (other == candidates.end()) return MarkerFix::Status::kGood;
  Candidate& second = candidates[1];
  std::swap(second, *other);
  const double scale = std::max(1.0, first.residuals.cost / (kCornerRows * markers_used));
  const double decisive = kCornerRows * (limits.flip_ratio * limits.flip_ratio - 1.0);
  if ((second.residuals.cost - first.residuals.cost) / scale >= decisive) return MarkerFix::Status::kGood;
  if (!predicted) return MarkerFix::Status::kAmbiguous;
  const double second_yaw = toPose2(second.map_from_base).yaw_rad;
  const double first_off = std::abs(angleBetween(predicted->yaw_rad, first_yaw));
  const double second_off = std::abs(angleBetween(predicted->yaw_rad, second_yaw));
  if (std::min(first_off, second_off) > limits.max_prediction_error_deg * kRadFromDeg ||
      std::abs(first_off - second_off) < 0.5 * yawApart(second))
    return MarkerFix::Status::kAmbiguous;
  if (second_off < first_off) std::swap(first, second);
  return MarkerFix::Status::kGood;
}

double MarkerLocalizer::imageError(const MarkerSighting& sighting,
                                   const Eigen::Isometry3d& map_from_base) const {
  const MappedMarker& marker = map_.markers.at(sighting.corners.id);
  return marker_detail::imageError(estimator_.camera(), sighting.corners, marker.size_m,
                                   (map_from_base * base_from_optical_).inverse() * marker.map_from_marker);
}

/// How far a robot would be off the floor [standard deviations]: height, and tilt about two axes.
Eigen::Vector3d MarkerLocalizer::floorResidual(const Eigen::Isometry3d& map_from_base) const {
  const Eigen::Vector3d up = map_from_base.linear().col(2);
  const double tilt_sigma = params_.tilt_sigma_deg * kRadFromDeg;
  return {map_from_base.translation().z() / params_.height_sigma_m, up.x() / tilt_sigma, up.y() / tilt_sigma};
}

}  // namespace frugal_nav
