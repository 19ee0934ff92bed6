#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

// What points of visual odometry (see voAnchors()) tell of what stands on the floor and of the floor itself.

/// How far a fitted depth may be off (logarithm) where a point lies: features at an edge often belong to what
/// is behind it.
constexpr double kVoGate = 0.4;
/// The same where several points agree on something nearer: the network may not see a thing at all.
constexpr double kUnseenGate = 1.0;

/// Whether two points lie at one depth.
bool isAsFar(const DepthAnchor& a, const DepthAnchor& b);

/// Whether the points as a whole lie where the last scale lets expect them (1/m, CV_32FC1): visual odometry
/// whose own scale is wrong must not overrule all else. False while nothing is expected.
bool agrees(const std::vector<DepthAnchor>& points, const cv::Mat& expected_pm);

/// Then none is agreed on any more.
void distrust(std::vector<DepthAnchor>& points);

/// Those that several of their neighbours agree with: the only ones for what follows.
std::vector<DepthAnchor> agreedOn(const std::vector<DepthAnchor>& points);

/// What stands on the floor, and low enough for the robot: inverse depth (CV_32FC1, the grid's size) between
/// neighbours at one depth and down to their foot; 0 elsewhere.
cv::Mat findStanding(const std::vector<DepthAnchor>& points, const ViewRays& rays, double max_height_m);

/// Tells `evidence` (see floorEvidence()) that what stands is no floor.
void denyFloor(const cv::Mat& standing, cv::Mat& evidence);

/// Tells it that points which lie on the floor are floor.
void confirmFloor(const std::vector<DepthAnchor>& points, const ViewRays& rays, cv::Mat& evidence);

/// What stands is upright: it is as far from head to foot.
std::vector<DepthAnchor> standingAnchors(const cv::Mat& standing);

}  // namespace frugal_nav
