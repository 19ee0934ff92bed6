#pragma once

#include <string>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/MarkerObservationArray.h>
#include <frugal_nav/localization/marker_localization.hpp>
#include <frugal_nav/ros/image_intake.hpp>

namespace frugal_nav {

/// Everything that was seen in an image, and what came of it.
MarkerObservationArray observationsMessage(const CameraFrame& frame, const MarkerImageResult& result,
                                           const MarkerMap& map);

/// A pose on the floor with its covariance of (x, y, yaw); z, roll and pitch are zero and sure.
geometry_msgs::PoseWithCovarianceStamped poseMessage(Stamp stamp, const std::string& frame, const Pose2& pose,
                                                     const Eigen::Matrix3d& covariance);

/// A pose that someone says the robot has. With a covariance of zeros it gets the given deviations.
struct GivenPose {
  PoseFix fix;
  std::string fault;  ///< why it cannot be used; empty when it can
};
GivenPose givenPose(const geometry_msgs::PoseWithCovarianceStamped& msg, const std::string& map_frame,
                    double sigma_m, double sigma_rad);

/// The map's markers with their ids, grey; those of the last image green when accepted and red when refused,
/// with a line from the camera to where the camera sees them.
visualization_msgs::MarkerArray mapMarkers(const MarkerMap& map, const MarkerImageResult& result,
                                           const Eigen::Isometry3d& map_from_optical);

}  // namespace frugal_nav
