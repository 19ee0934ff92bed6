#pragma once

#include <vector>

#include <Eigen/Core>

namespace frugal_nav {

/// Label of a point that belongs to no cluster.
constexpr int kNoise = -1;

/// Density-based clusters (Ester et al., KDD 1996): a point with `min_samples` points within `eps`, itself
/// included, is a core; clusters are what cores reach. Labels count from 0 in the order of the points; a
/// border point goes to the first cluster that reaches it. All pairs are compared: for up to some thousand
/// points.
std::vector<int> dbscan(const std::vector<Eigen::Vector3d>& points, double eps, int min_samples);

}  // namespace frugal_nav
