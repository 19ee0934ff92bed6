#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/gap_sighting.hpp>
#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/column_profile.hpp>
#include <frugal_nav/perception/column_surface.hpp>

namespace frugal_nav {

/// What is a gap.
struct GapFinderParams {
  double least_inverse = 0.02;
  double clip_ratio = 10.0;
  double noise_width = 0.02;
  double min_width = 0.04;
  double clear_m = 1.2;
  double open_m = 3.5;
  std::string node = "bearing";
  double node_scale_m = 0.2;
  double node_default_m = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("least_inverse", least_inverse,
          Field{"", "smallest relative inverse depth, as a share of the image's largest", 1e-4, 1.0});
    visit("clip_ratio", clip_ratio,
          Field{"",
                "relative depth is clipped at this many times that of the nearest column: without it one "
                "far column moves the mean",
                1.0, 1000.0});
    visit("noise_width", noise_width,
          Field{"", "near runs narrower than this share of the image are noise", 0.0, 0.5});
    visit("min_width", min_width, Field{"", "a narrower open run, likewise, is no gap", 0.0, 1.0});
    visit("clear_m", clear_m,
          Field{"m", "an open column must be clear up to here: a mean alone finds a gap in a near wall", 0.0,
                20.0});
    visit("open_m", open_m,
          Field{"m", "a column clear up to here is open whatever the mean; 0: the mean decides", 0.0, 50.0});
    visit("node", node,
          Field{"", "gap node: at the gap's bearing and metric depth, or the paper's block offsets", -1, 1,
                "bearing|literal"});
    visit("node_scale_m", node_scale_m, Field{"m", "literal: the planning grid's scale", 0.01, 5.0});
    visit("node_default_m", node_default_m,
          Field{"m", "bearing: distance of the node while no depth is known", 0.05, 10.0});
  }
};

/// Which columns are open (0) and near (1): the profile against its mean, without noise, and clear in metres
/// where `surfaces` know.
std::vector<char> openColumns(const ColumnProfile& profile, const std::vector<ColumnSurface>& surfaces,
                              const GapFinderParams& params);

/// Metric width between two bearings seen from the camera at the depth of the nearer bound:
/// w = Z (tan left - tan right).
double gapWidth(double depth_m, double left_rad, double right_rad);

/// The paper's gap node: p + scale (block right + forward).
Eigen::Vector2d literalGapNode(const Pose2& odom_from_base, int block, double scale_m);

/// The gap of an image, its stamp left out.
GapSighting findGap(const std::vector<char>& near, const std::vector<ColumnSurface>& surfaces,
                    const ViewRays& rays, const Pose2& odom_from_base, const GapFinderParams& params);

}  // namespace frugal_nav
