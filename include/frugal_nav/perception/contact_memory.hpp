#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/floor_contact.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// How long the feet of things are remembered.
struct ContactMemoryParams {
  double cell_m = 0.04;
  double max_age_s = 8.0;
  double max_depth_m = 3.0;
  double drift_per_s = 0.01;
  double height_m = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("cell_m", cell_m, Field{"m", "feet nearer to each other than this are one", 0.005, 1.0});
    visit("max_age_s", max_age_s,
          Field{"s",
                "feet not seen for longer are forgotten: from 1.2 m, where they leave the view, to the thing "
                "itself at 0.15 m/s",
                0.0, 600.0});
    visit("max_depth_m", max_depth_m, Field{"m", "farther feet are not kept: they are less sure", 0.3, 20.0});
    visit("drift_per_s", drift_per_s,
          Field{"1/s", "error that a remembered distance gains: odometry, and things that move", 0.0, 1.0});
    visit(
        "height_m", height_m,
        Field{"m", "height above the lowest part in view up to which a thing is thought upright", 0.02, 2.0});
  }
};

/// Where things stood on the floor, in odom: the floor is in view from some distance on only, and what comes
/// nearer would else be told by the network alone.
class ContactMemory {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit ContactMemory(const ContactMemoryParams& params);

  /// What is known of the part of the view whose feet lie below the image.
  std::vector<DepthAnchor> recall(Stamp stamp, const Pose2& odom_from_base, const ViewRays& rays) const;

  /// Takes the lines of an image in place of what was kept of the same part of the view. Stamps must not go
  /// back: reset() first.
  void update(Stamp stamp, const Pose2& odom_from_base, const ViewRays& rays,
              const std::vector<FloorContact>& contacts);
  void reset() { feet_.clear(); }

 private:
  struct Foot {
    Eigen::Vector2d p_odom;
    double sigma_m;
    Stamp seen;
  };

  ContactMemoryParams params_;
  std::map<std::pair<int, int>, Foot> feet_;  // by cell
};

}  // namespace frugal_nav
