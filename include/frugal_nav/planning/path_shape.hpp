#pragma once

#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/planning/astar.hpp>

namespace frugal_nav {

/// Replaces runs of a cell path by straight lines wherever the line is passable and costs no more than the
/// run: since nearness to obstacles costs, a shortcut never trades clearance away. Returns the corners that
/// remain.
std::vector<Cell> straighten(const WeightGrid& grid, const std::vector<Cell>& cells);

/// Points along a polyline, at most `spacing_m` apart, with the corners kept; each looks along its line.
/// Corners that coincide are dropped; a single point keeps the yaw given.
Path2 resample(const std::vector<Eigen::Vector2d>& corners, double spacing_m, double single_yaw_rad);

/// Length of a path [m].
double lengthOf(const Path2& path);

}  // namespace frugal_nav
