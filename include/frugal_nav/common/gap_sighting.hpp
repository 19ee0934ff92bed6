#pragma once

#include <limits>
#include <string>

#include <Eigen/Core>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// The widest open part of one image: what perception/ finds and planning/ drives through. The message Gap
/// carries it.
struct GapSighting {
  Stamp stamp{};       ///< of the image
  bool found = false;  ///< false: there is none, or the image is of no use; `reason` says which
  std::string reason;
  double left_column_px = 0.0;  ///< its edges in the image as given
  double right_column_px = 0.0;
  double left_bearing_rad = 0.0;  ///< the same in base_link, left positive
  double right_bearing_rad = 0.0;
  double bearing_rad = 0.0;                                   ///< of its centre
  double width_m = std::numeric_limits<double>::quiet_NaN();  ///< between what bounds it; NaN unknown
  double depth_m = std::numeric_limits<double>::quiet_NaN();  ///< of the nearer bound; NaN unknown
  int block = 0;  ///< vertical segment of the image that holds its centre: -2 (left) to 2 (right)
  Eigen::Vector2d p_odom = Eigen::Vector2d::Zero();  ///< the gap node
};

}  // namespace frugal_nav
