#include <cmath>
#include <numeric>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/odometry/wheel_calibration.hpp>

namespace frugal_nav {
namespace {

Eigen::Vector2d centreOf(const std::vector<Eigen::Vector2d>& errors, const char* direction) {
  if (errors.empty()) {
    throw ConfigError(std::string("wheel calibration: no ") + direction +
                      " square: drive at least one each way");
  }
  const Eigen::Vector2d sum = std::accumulate(errors.begin(), errors.end(), Eigen::Vector2d::Zero().eval());
  if (!sum.allFinite())
    throw ConfigError(std::string("wheel calibration: a ") + direction + " error is not finite");
  return sum / static_cast<double>(errors.size());
}

}  // namespace

WheelCalibration calibrateWheels(const SquareErrors& errors, double side_m, double separation_m) {
  if (!(side_m > 0.0) || !(separation_m > 0.0)) {
    throw ConfigError("wheel calibration: the square's side and the wheel separation must be positive");
  }
  const Eigen::Vector2d cw = centreOf(errors.clockwise, "clockwise");
  const Eigen::Vector2d ccw = centreOf(errors.counter_clockwise, "counter-clockwise");

  // Borenstein & Feng, eqs. 3.9-3.12: alpha, the angle a turn falls short (wrong separation), pushes both
  // ends back along x and apart along y; beta, the bend of a leg to the left (unequal wheels), does the
  // converse. Both coordinates tell the same: their mean is used.
  const double alpha = (cw.x() + ccw.x() + cw.y() - ccw.y()) / (-8.0 * side_m);
  const double beta = (cw.x() - ccw.x() + cw.y() + ccw.y()) / (-8.0 * side_m);
  if (std::abs(alpha) > M_PI / 4.0 || std::abs(beta) > M_PI / 4.0) {
    throw ConfigError(
        "wheel calibration: the errors are too large for squares of this side: check their units");
  }

  // A leg bends by beta over its length, so R = (L/2) / sin(beta/2), and the right wheel rolls (R + b/2)
  // while the left one rolls (R - b/2); written with 1/R, which is zero for equal wheels.
  const double curvature = 2.0 * std::sin(beta / 2.0) / side_m;
  const double ratio = (1.0 + curvature * separation_m / 2.0) / (1.0 - curvature * separation_m / 2.0);
  return {2.0 / (ratio + 1.0), 2.0 / (1.0 / ratio + 1.0), (M_PI / 2.0) / (M_PI / 2.0 - alpha)};
}

}  // namespace frugal_nav
