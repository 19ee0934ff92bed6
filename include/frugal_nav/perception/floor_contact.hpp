#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// How the line is found on which things stand.
struct FloorContactParams {
  double geometry_sigma = 0.18;
  double truncation = 2.0;
  double colour_cost = 1.2;
  double network_cost = 1.0;
  double network_cap = 5.0;
  double edge_bonus = 1.5;
  double stand_height_m = 0.15;
  double horizon_margin_rad = 0.02;
  double max_depth_m = 6.0;
  int smooth_columns = 3;
  double min_edge = 4.0;
  double sharp_sigma_px = 1.0;
  double blurred_sigma_cells = 2.0;
  double pitch_sigma_rad = 0.004;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("geometry_sigma", geometry_sigma,
          Field{"", "error of the fitted inverse depth as a share of it, when floor and thing are told apart",
                0.01, 1.0});
    visit("truncation", truncation, Field{"", "a row's error counts up to this many sigma", 0.5, 10.0});
    visit("colour_cost", colour_cost,
          Field{"", "cost of a row whose colour says otherwise; the geometry's is at most truncation squared",
                0.0, 100.0});
    visit("network_cost", network_cost,
          Field{"",
                "where the network tells the floor: cost of a row, as a share of minus the logarithm of "
                "what the network gives it",
                0.0, 100.0});
    visit("network_cap", network_cap,
          Field{"", "odds (logarithm) of the network count up to this: it is surer than it should be", 0.1,
                100.0});
    visit("edge_bonus", edge_bonus,
          Field{"", "rows' worth of preference for a line where the colour changes", 0.0, 100.0});
    visit("stand_height_m", stand_height_m,
          Field{"m", "height over the line that must look upright", 0.02, 2.0});
    visit("horizon_margin_rad", horizon_margin_rad,
          Field{"rad", "no line is looked for nearer than this to the horizon", 0.0, 0.3});
    visit("max_depth_m", max_depth_m, Field{"m", "lines farther than this are of no use", 0.5, 50.0});
    visit("smooth_columns", smooth_columns,
          Field{"", "neighbours to each side whose median a line must not leave", 0, 20});
    visit("min_edge", min_edge,
          Field{"", "change of grey level across a line from which it is taken as sharp", 0.0, 255.0});
    visit("sharp_sigma_px", sharp_sigma_px,
          Field{"px", "standard deviation of a sharp line's row, in the image as given", 0.05, 50.0});
    visit("blurred_sigma_cells", blurred_sigma_cells,
          Field{"", "that of any other line, in cells", 0.1, 20.0});
    visit("pitch_sigma_rad", pitch_sigma_rad,
          Field{"rad", "how well the camera's pitch is known while driving", 0.0, 0.1});
  }
};

/// What the floor does in one column of the grid, seen from the bottom.
struct FloorContact {
  enum class State {
    kOpen,     ///< it runs on to the horizon
    kContact,  ///< something stands on it
    kHidden    ///< none is seen: something stands nearer than the image's lowest row shows
  };
  State state = State::kHidden;
  int row = 0;             ///< lowest row of the thing; kOpen: the first row below the horizon
  double image_row = 0.0;  ///< the line between thing and floor, in the image as given [px]
  double depth_m = 0.0;    ///< along the optical axis, from camera height and pitch; kContact only
  double sigma_m = 0.0;    ///< standard deviation of depth_m
};

/// What speaks for floor and against it in each cell, from a mask by colour (CV_8UC1, 255 floor) or from a
/// probability (CV_32FC1): CV_32FC1, the cost of calling it no floor less that of calling it floor.
cv::Mat floorEvidence(const cv::Mat& mask_or_probability, const FloorContactParams& params);

/// For each column the row from which on something stands on the floor: below it the fitted inverse depth is
/// the floor's and the looks too, above it the depth stays that of the line. Looks and geometry are costs
/// of one sum, so that a floor-coloured thing is none and a patterned floor still is. `inverse_depth_pm`
/// (CV_32FC1 [1/m], the grid's size) is empty while no scale is known: then the looks decide alone. Empty
/// `evidence` (see floorEvidence()) leaves the decision to the geometry.
std::vector<FloorContact> findFloorContacts(const cv::Mat& evidence, const cv::Mat& inverse_depth_pm,
                                            const ViewRays& rays, const FloorContactParams& params);

/// Moves the lines to the sharpest change of the image (CV_8UC3) near them and gives depths and sigmas.
void refineContacts(const cv::Mat& bgr, const ViewRays& rays, const FloorContactParams& params,
                    std::vector<FloorContact>& contacts);

/// The floor of the grid by its columns: CV_8UC1, 255 floor.
cv::Mat floorOf(const std::vector<FloorContact>& contacts, const ViewRays& rays);

}  // namespace frugal_nav
