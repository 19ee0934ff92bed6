#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/perception/floor_contact.hpp>
#include <frugal_nav/perception/floor_mask.hpp>
#include <frugal_nav/perception/metric_fit.hpp>
#include <frugal_nav/perception/obstacle_motion.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

// What tells metres in one image: the samples that a and b are fitted to, and the anchors that mend the
// fitted depth where they lie. `inverse` is the network's answer on the grid.

template <class T>
void append(const std::vector<T>& more, std::vector<T>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Points of visual odometry.
std::vector<MetricSample> voSamples(const DepthView& view, const ViewRays& rays, const cv::Mat& inverse,
                                    double scale_sigma);

/// Floor: camera height and pitch give its depth without motion or texture.
std::vector<MetricSample> floorSamples(const cv::Mat& floor_mask, const ViewRays& rays,
                                       const cv::Mat& inverse, double pitch_sigma_rad);

/// The goal's head, whose size told its distance.
std::vector<MetricSample> goalSamples(const DepthView& view, const ViewRays& rays, const cv::Mat& inverse,
                                      double least_relative_sigma);

/// Points of visual odometry. Those that several others agree with have an unseen_gate.
std::vector<DepthAnchor> voAnchors(const DepthView& view, const ViewRays& rays, double scale_sigma);

/// What stands on the floor, upright from its foot up to where its colour changes (`small_bgr`: CV_8UC3, the
/// image on the grid), unless several points of visual odometry on it lie elsewhere; `fitted` (CV_32FC1
/// [1/m]) tells what is one thing.
std::vector<DepthAnchor> contactAnchors(const std::vector<FloorContact>& contacts, const ViewRays& rays,
                                        const cv::Mat& small_bgr, const std::vector<DepthAnchor>& points,
                                        const cv::Mat& fitted);

/// The cue that an obstacle's distance rests on most.
std::string mainCue(const SeenObstacle& seen, const NearestObstacle& obstacle, const DepthView& view,
                    const std::vector<FloorContact>& contacts, bool uses_floor);

}  // namespace frugal_nav
