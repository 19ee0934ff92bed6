#pragma once

#include <string>
#include <vector>

#include <frugal_nav/localization/pose_filter.hpp>

namespace frugal_nav::eval {

/// One number line of a UTIAS file: its time and what follows.
struct MrclamLine {
  Stamp stamp{};
  std::vector<double> values;
};

/// One robot's run of the UTIAS Multi-Robot Cooperative Localization and Mapping data set (Leung et al., IJRR
/// 30(8), 2011).
struct MrclamRun {
  std::string robot;                     ///< "Robot1"
  std::vector<MrclamLine> odometry;      ///< commanded speed [m/s], yaw rate [rad/s]
  std::vector<MrclamLine> measurements;  ///< landmark's x, y [m], range [m], bearing [rad]
  std::vector<MrclamLine> truth;         ///< x, y [m], yaw [rad]
};

/// Every robot of a folder of the data set, in the order of their names; measurements of other robots are
/// left out. Throws ConfigError naming the file and what is wrong with it.
std::vector<MrclamRun> readMrclam(const std::string& folder);

/// The filter's and the sensor's parameters for these robots. Both were found on robots 1 and 2 of set 6: the
/// sightings of one approach err alike, so that their deviations are wider than the scatter of single ones.
struct MrclamParams {
  PoseFilterParams filter;
  double range_sigma_m = 0.05;
  double range_sigma_share = 0.18;
  double bearing_sigma_rad = 0.1;

  MrclamParams();

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("filter", filter);
    visit("range_sigma_m", range_sigma_m, Field{"m", "of a range, near", 1e-3, 10.0});
    visit("range_sigma_share", range_sigma_share, Field{"", "of a range, a metre of it", 0.0, 1.0});
    visit("bearing_sigma_rad", bearing_sigma_rad, Field{"rad", "of a bearing", 1e-3, 1.0});
  }
};

/// How well the filter knew where it was, at every odometry stamp with truth around it.
struct MrclamScore {
  double position_rmse_m = 0.0;
  double yaw_rmse_deg = 0.0;
  double anees = 0.0;        ///< squared error over what the covariance says, by 3: 1 is consistent
  double gated_share = 0.0;  ///< of the sightings
};

/// Runs the filter from the true pose at the first odometry stamp that has one. Throws ConfigError when a run
/// has none.
MrclamScore scoreMrclam(const MrclamRun& run, const MrclamParams& params);

}  // namespace frugal_nav::eval
