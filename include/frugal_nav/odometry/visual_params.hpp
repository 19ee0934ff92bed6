#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Which features are followed from image to image, and how.
struct VisualFeatureParams {
  std::string method = "tracking";
  int max_features = 300;
  int region_features = 250;
  int grid_columns = 16;
  int fast_threshold = 14;
  int klt_window_px = 15;
  int klt_levels = 4;
  double forward_backward_px = 0.8;
  int orb_features = 700;
  double ratio = 0.8;
  double search_radius = 0.12;

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    visit("method", method,
          Field{"", "tracking: corners followed by optical flow; matching: ORB descriptors compared",
                -infinity, infinity, "tracking|matching"});
    visit("max_features", max_features,
          Field{"", "corners kept over the whole image: beyond 300 the pose gains little", 50, 2000});
    visit("region_features", region_features,
          Field{"", "corners kept inside the nearest obstacle's region, where the paper asks for 200", 0,
                2000});
    visit("grid_columns", grid_columns,
          Field{"", "cells across the image that share the corners, so that all of the view is used", 2, 64});
    visit("fast_threshold", fast_threshold,
          Field{"", "grey levels by which a corner's ring differs; it is halved where an image has few", 2,
                100});
    visit("klt_window_px", klt_window_px, Field{"px", "side of the patch that optical flow compares", 5, 51});
    visit("klt_levels", klt_levels, Field{"", "halvings of the image: four follow motions of 100 px", 0, 7});
    visit("forward_backward_px", forward_backward_px,
          Field{"px", "a corner that does not come back this close is given up", 0.05, 10.0});
    visit("orb_features", orb_features, Field{"", "ORB features an image", 50, 5000});
    visit("ratio", ratio, Field{"", "best over second best descriptor distance (Lowe's test)", 0.3, 1.0});
    visit(
        "search_radius", search_radius,
        Field{"", "a match lies within this share of the image's width of where it is expected", 0.01, 2.0});
  }
};

/// When two views make a map, and what a good point is.
struct VisualMapParams {
  int window = 6;
  int fixed_keyframes = 4;
  double keyframe_distance_m = 0.05;
  double keyframe_depth_share = 0.04;
  double keyframe_turn_rad = 0.14;
  double min_baseline_m = 0.05;
  double min_start_parallax_px = 6.0;
  double min_parallax_rad = 0.012;
  double max_reprojection_px = 2.0;
  int min_start_points = 30;
  double max_depth_m = 15.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("window", window, Field{"", "keyframes that are adjusted together", 2, 20});
    visit("fixed_keyframes", fixed_keyframes,
          Field{"", "older keyframes that are kept but not moved: they hold scale and direction", 1, 20});
    visit("keyframe_distance_m", keyframe_distance_m,
          Field{"m", "least way between keyframes: the paper's baseline for scale", 0.005, 1.0});
    visit(
        "keyframe_depth_share", keyframe_depth_share,
        Field{"", "way between keyframes as a share of the scene's median depth: about 2 degrees of parallax",
              0.0, 0.5});
    visit("keyframe_turn_rad", keyframe_turn_rad,
          Field{"rad", "a turn that makes a keyframe: an eighth of the view leaves it", 0.02, 1.0});
    visit("min_baseline_m", min_baseline_m,
          Field{"m", "wheel distance below which no scale is taken: encoder and slip noise", 0.005, 1.0});
    visit("min_start_parallax_px", min_start_parallax_px,
          Field{"px", "median motion of the features left after the turn is taken out, before a map starts",
                1.0, 100.0});
    visit("min_parallax_rad", min_parallax_rad,
          Field{"rad", "least angle between the rays of a new point: 0.012 leaves about 10 % of depth noise",
                0.001, 0.5});
    visit("max_reprojection_px", max_reprojection_px,
          Field{"px", "a point off by more in an image is an outlier there", 0.3, 20.0});
    visit("min_start_points", min_start_points, Field{"", "points a new map must have", 10, 500});
    visit("max_depth_m", max_depth_m,
          Field{"m", "points farther than this are of no use indoors", 1.0, 1000.0});
  }
};

/// What wheels and floor say about the camera's motion.
struct VisualMotionParams {
  std::string wheels = "motion";
  bool planar = true;
  double planar_sigma_m = 0.005;
  double planar_sigma_rad = 0.004;
  double wheel_sigma = 0.01;
  double wheel_sigma_m = 0.002;
  double max_scale_ratio = 1.5;
  int scale_samples = 20;

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    visit("wheels", wheels,
          Field{"", "motion: scale, prediction and fallback come from the wheels; scale: only distances",
                -infinity, infinity, "motion|scale"});
    visit("planar", planar, Field{"", "whether the robot stays upright on a flat floor; false: hand-held"});
    visit("planar_sigma_m", planar_sigma_m,
          Field{"m", "how far the base leaves the floor's plane", 1e-4, 1.0});
    visit("planar_sigma_rad", planar_sigma_rad, Field{"rad", "how far the base tilts", 1e-4, 1.0});
    visit("wheel_sigma", wheel_sigma,
          Field{"", "relative error of a wheel distance; slip beyond it is an outlier", 1e-3, 1.0});
    visit("wheel_sigma_m", wheel_sigma_m, Field{"m", "error of any wheel distance", 1e-4, 0.1});
    visit("max_scale_ratio", max_scale_ratio,
          Field{"", "wheels and images that differ by more for several keyframes: the map is given up", 1.05,
                10.0});
    visit("scale_samples", scale_samples, Field{"", "baselines whose median ratio is the scale", 3, 500});
  }
};

/// When an image can be used, and when the pose found in it is believed.
struct VisualCheckParams {
  int min_features = 25;
  int min_inliers = 15;
  double min_inlier_share = 0.4;
  double dark_level = 8.0;
  double bright_level = 247.0;
  double min_contrast = 2.5;
  double blur_drop = 0.25;
  double rotation_residual_px = 1.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("min_features", min_features,
          Field{"", "features followed below which nothing is estimated", 8, 500});
    visit("min_inliers", min_inliers, Field{"", "map points that must fit a pose", 6, 500});
    visit("min_inlier_share", min_inlier_share,
          Field{"", "share of the map points seen that must fit", 0.1, 1.0});
    visit("dark_level", dark_level, Field{"", "mean grey level below which an image is dark", 0.0, 255.0});
    visit("bright_level", bright_level, Field{"", "mean grey level above which it is saturated", 0.0, 255.0});
    visit("min_contrast", min_contrast,
          Field{"", "standard deviation of the grey levels below which nothing is to be seen", 0.0, 100.0});
    visit(
        "blur_drop", blur_drop,
        Field{"", "share of the usual sharpness below which lost features are put down to blur", 0.01, 1.0});
    visit("rotation_residual_px", rotation_residual_px,
          Field{"px", "median motion left after the turn is taken out up to which the motion is a turn only",
                0.2, 10.0});
  }
  std::string check() const {
    return dark_level < bright_level ? "" : "dark_level must be below bright_level";
  }
};

/// All parameters of monocular visual odometry.
struct VisualOdometryParams {
  VisualFeatureParams features;
  VisualMapParams map;
  VisualMotionParams motion;
  VisualCheckParams checks;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("features", features);
    visit("map", map);
    visit("motion", motion);
    visit("checks", checks);
  }
};

}  // namespace frugal_nav
