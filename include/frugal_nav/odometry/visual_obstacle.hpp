#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/types.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav {

/// How points near the nearest obstacle become its place.
struct VisualObstacleParams {
  int min_keypoints = 200;
  double eps_m = 0.35;
  int min_samples = 6;
  double min_height_m = 0.04;
  double max_height_m = 0.8;
  double max_relative_sigma = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("min_keypoints", min_keypoints,
          Field{"", "features the region must hold, else it is skipped: the paper's rule", 1, 5000});
    visit("eps_m", eps_m, Field{"m", "points of one obstacle have neighbours this near (DBSCAN)", 0.01, 5.0});
    visit("min_samples", min_samples, Field{"", "points within eps_m that make a core (DBSCAN)", 1, 100});
    visit("min_height_m", min_height_m, Field{"m", "lower points are floor", -1.0, 1.0});
    visit("max_height_m", max_height_m, Field{"m", "higher points pass over the robot", 0.05, 5.0});
    visit("max_relative_sigma", max_relative_sigma,
          Field{"", "points whose distance is less sure than this share of it are left out", 0.01, 1.0});
  }
  std::string check() const {
    return min_height_m < max_height_m ? "" : "min_height_m must be below max_height_m";
  }
};

/// The nearest obstacle as the map's points show it.
struct VisualObstacle {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();  ///< mean of the cluster
  double distance_m = 0.0;                           ///< from base_link on the floor, to the mean
  double bearing_rad = 0.0;                          ///< in base_link, left positive
  double sigma_m = 0.0;                              ///< of the distance: of points, scale and spread
  int points = 0;
};

/// An obstacle, or why there is none.
struct VisualObstacleResult {
  std::optional<VisualObstacle> obstacle;
  std::string reason;  ///< empty when there is one
  int keypoints = 0;   ///< features in the region
};

/// Clusters the points of an output that lie in an image region; the nearest cluster's mean is the obstacle.
VisualObstacleResult findNearestObstacle(const VisualOdometryOutput& output, const cv::Rect& region,
                                         const VisualObstacleParams& params);

}  // namespace frugal_nav
