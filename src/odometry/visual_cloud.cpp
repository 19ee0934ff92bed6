#include <cmath>

#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <frugal_nav/odometry/visual_cloud.hpp>

namespace frugal_nav {
namespace {

constexpr double kReach_m = 500.0;  // farther points would overflow the filter's voxel index

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
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : points_) cloud->emplace_back(p.x(), p.y(), p.z());
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  const auto leaf = static_cast<float>(voxel_m_);
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setInputCloud(cloud);
  pcl::PointCloud<pcl::PointXYZ> kept;
  grid.filter(kept);
  points_.clear();
  const std::size_t skipped = kept.size() > max_points_ ? kept.size() - max_points_ : 0;
  for (std::size_t i = skipped; i < kept.size(); ++i) points_.push_back(kept[i].getVector3fMap());
  is_filtered_ = true;
}

}  // namespace frugal_nav
