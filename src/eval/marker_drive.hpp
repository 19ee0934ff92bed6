#pragma once

#include "as_printed_filter.hpp"
#include "marker_hall.hpp"
#include "pose_score.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/lidar_stack.hpp>
#include <frugal_nav/localization/marker_localization_params.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {

/// A tour through a hall of markers and what is compared on it.
struct MarkerDriveParams {
  double image_rate_hz = 5.0;
  double image_delay_s = 0.3;
  double near_m = 3.0;
  AsPrintedParams as_printed;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("image_rate_hz", image_rate_hz, Field{"Hz", "images a second", 0.5, 30.0});
    visit("image_delay_s", image_delay_s, Field{"s", "of the images of the delayed filter", 0.0, 1.5});
    visit("near_m", near_m,
          Field{"m", "errors are those at images that show a marker no farther than this", 0.5, 10.0});
    visit("as_printed", as_printed);
  }
};

/// What drives and what localizes: the nodes' own parameters.
struct MarkerStackParams {
  LidarStackParams drive;
  MarkerLocalizationParams localization;
};

/// One instant of a drive.
struct MarkerDriveSample {
  double time_s = 0.0;
  Pose2 truth;
  Pose2 believed;
  Pose2 as_printed;
  double sigma_m = 0.0;  ///< of the position believed, both ways together
  bool is_near = false;  ///< the camera saw a marker near enough
};

/// What came of a drive.
struct MarkerDriveRecord {
  std::string outcome;  ///< "toured", "aborted" or "time_out"
  std::string reason;
  PoseScore near;     ///< when an image came that shows a marker near enough
  PoseScore delayed;  ///< likewise, of the filter whose images come late
  PoseScore printed;  ///< as `near`, of the paper's filter
  PoseScore all;      ///< from the first fix on, markers or not
  int images = 0;
  int fixes = 0;                          ///< images that moved the filter
  int flips = 0;                          ///< of these, with a yaw wrong by more than 20 degrees
  std::vector<double> drift_pct;          ///< error after 10 s without images, by the way
  std::vector<double> waypoint_errors_m;  ///< of the waypoints said to be reached, from the truth
  int contacts = 0;
  std::string touched;
  double time_s = 0.0;
  double length_m = 0.0;
  std::vector<MarkerDriveSample> samples;  ///< at the images, and as often without them
};

/// Stands, then drives the tour by what localization says, through the same classes as the nodes. The camera
/// is covered for ten seconds of every twenty-five. Filters beside, which see what it sees, are the same one
/// with late images, and the paper's.
MarkerDriveRecord driveMarkerHall(const MarkerHall& hall, const RobotModel& robot,
                                  const MarkerStackParams& stack, const MarkerDriveParams& params,
                                  std::uint64_t seed);

}  // namespace frugal_nav::eval
