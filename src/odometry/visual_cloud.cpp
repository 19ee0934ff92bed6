#include <cmath>
#include <map>
#include <tuple>

#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <frugal_nav/odometry/visual_cloud.hpp>

namespace frugal_nav {
namespace {

constexpr double kReach_m = 500.0;      // farther points are no part of a building
constexpr double kBlock_voxels = 1000;  // PCL numbers the voxels of a cloud with 31 bits

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

}  // namespace

void VisualCloud::add(const std::vector<Eigen::Vector3d>& points_odom) {
  for (const Eigen::Vector3d& p : points_odom) {
    if (p.allFinite() && p.cwiseAbs().maxCoeff() < kReach_m) points_.push_back(p.cast<float>());
  }
  is_filtered_ = is_filtered_ && points_odom.empty();
  if (points_.size() > 2 * max_points_) filter();
}

void VisualCloud::clear() {
  points_.clear();
  is_filtered_ = true;
}

const std::vector<Eigen::Vector3f>& VisualCloud::points() const {
  if (!is_filtered_) filter();
  return points_;
}

void VisualCloud::filter() const {
  const auto leaf = static_cast<float>(voxel_m_);
  const auto blockOf = [block_m = kBlock_voxels * voxel_m_](float x) {
    return static_cast<int>(std::floor(static_cast<double>(x) / block_m));
  };
  std::map<std::tuple<int, int, int>, Cloud::Ptr> blocks;
  for (const Eigen::Vector3f& p : points_) {
    Cloud::Ptr& block = blocks[{blockOf(p.x()), blockOf(p.y()), blockOf(p.z())}];
    if (!block) block = pcl::make_shared<Cloud>();
    block->emplace_back(p.x(), p.y(), p.z());
  }
  points_.clear();
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(leaf, leaf, leaf);
  for (const auto& [index, block] : blocks) {
    grid.setInputCloud(block);
    Cloud kept;
    grid.filter(kept);
    for (const pcl::PointXYZ& p : kept) points_.push_back(p.getVector3fMap());
  }
  if (points_.size() > max_points_)
    points_.erase(points_.begin(), points_.end() - static_cast<std::ptrdiff_t>(max_points_));
  is_filtered_ = true;
}

}  // namespace frugal_nav
