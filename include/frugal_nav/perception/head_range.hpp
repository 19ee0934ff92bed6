#pragma once

#include <string>

#include <Eigen/Geometry>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/detection.hpp>

namespace frugal_nav {

/// What is known of the heads a detector boxes.
struct HeadRangeParams {
  double head_height_m = 0.232;
  double head_depth_m = 0.20;
  double head_height_share = 0.06;
  double edge_noise_px = 1.0;
  double edge_noise_share = 0.02;
  double direction_noise_rad = 0.003;
  double min_box_px = 10.0;
  double border_px = 2.0;
  double border_share = 0.12;
  double min_above_floor_m = 0.8;
  double max_above_floor_m = 2.3;
  double max_range_m = 12.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("head_height_m", head_height_m,
          Field{"m", "height of what the box holds; calibrate it: true distance over shown, times this", 0.02,
                3.0});
    visit("head_depth_m", head_depth_m,
          Field{"m",
                "front to back of what the box holds, which adds to its height when seen from below; 0: flat",
                0.0, 3.0});
    visit("head_height_share", head_height_share,
          Field{"", "standard deviation of the height between people, as a share of it", 0.0, 0.5});
    visit("edge_noise_px", edge_noise_px, Field{"px", "standard deviation of a box's edge", 0.0, 50.0});
    visit("edge_noise_share", edge_noise_share,
          Field{"", "more of it, as a share of the box's height: large boxes are no sharper", 0.0, 0.5});
    visit("direction_noise_rad", direction_noise_rad,
          Field{"rad", "standard deviation of where the camera looks: a body that rocks, stamps of turns",
                0.0, 0.1});
    visit("min_box_px", min_box_px,
          Field{"px", "a lower box gives no distance: an edge's error would be a tenth of it", 1.0, 1000.0});
    visit("border_px", border_px,
          Field{"px", "a box closer to the image's edge is cut off and gives no distance", 0.0, 100.0});
    visit("border_share", border_share,
          Field{"",
                "the same as a share of the box's height: a detector's box ends before the edge that cuts it",
                0.0, 1.0});
    visit("min_above_floor_m", min_above_floor_m,
          Field{"m", "lowest centre of a head (someone sitting)", -10.0, 10.0});
    visit("max_above_floor_m", max_above_floor_m, Field{"m", "highest centre of a head", -10.0, 10.0});
    visit("max_range_m", max_range_m, Field{"m", "farther heads are not believed", 0.5, 100.0});
  }
  std::string check() const {
    return min_above_floor_m < max_above_floor_m ? ""
                                                 : "min_above_floor_m must be less than max_above_floor_m";
  }
};

/// Where a head is, from one box.
struct HeadSighting {
  enum class Status {
    kGood,
    kNotFinite,   ///< the box, or where the lens would show it, is no number
    kCutOff,      ///< it touches the image's edge: its height is not the head's
    kTooSmall,    ///< its height is too uncertain
    kTooFar,      ///< beyond the largest range
    kImplausible  ///< too low or too high over the floor for a head
  };

  Status status = Status::kNotFinite;
  int class_id = 0;
  double score = 0.0;
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();  ///< on the ground, in base_link [m]
  double above_floor_m = 0.0;                        ///< of the head's centre
  double range_m = 0.0;                              ///< from base_link, on the ground
  double bearing_rad = 0.0;                          ///< from base_link, left positive
  Eigen::Matrix3d noise_m2 =
      Eigen::Matrix3d::Zero();  ///< of (p_base, above_floor_m), new with each frame: the box's noise
  Eigen::Vector3d from_eye_m =
      Eigen::Vector3d::Zero();  ///< from the camera to the head, in base_link: the way it is farther off when
                                ///< it is twice as large as assumed
  double size_sigma = 0.0;      ///< of the head's size over the assumed one, the same in all frames
  Eigen::Matrix3d place_by_box = Eigen::Matrix3d::Zero();  ///< of (p_base, above_floor_m) by the box's centre
                                                           ///< column, top and bottom [m/px]
};

/// In words, for messages.
const char* toText(HeadSighting::Status status);

/// Distance and bearing of heads from their boxes and a calibrated head height (paper 000, stage 1).
///
/// The box gives the depth along the optical axis, Z = f_y H / h_box; its centre the direction; camera pitch
/// is taken out by base_from_optical. H is the extent the head shows across the line of sight: that of an
/// ellipsoid, sqrt(height^2 cos^2 e + depth^2 sin^2 e) at elevation e; and off the axis the flat image
/// stretches it, so that Z = sqrt(1 + y^2) H(e) / h with y, h on the plane at distance one. For a flat head
/// ahead of a level camera that is the paper's formula.
class HeadRange {
 public:
  /// The optical frame (x right, y down, z ahead) in base_link. Throws ConfigError on parameters out of range
  /// and on a camera with a fault.
  HeadRange(const HeadRangeParams& params, const Pinhole& camera, const Eigen::Isometry3d& base_from_optical);

  /// Where the head in a box is. The fields are set as far as they are known; trust them when kGood.
  HeadSighting locate(const Detection& head) const;

  /// Whether a head there would lie whole in the image.
  bool couldSee(const Eigen::Vector2d& p_base, double above_floor_m) const;

  const Pinhole& camera() const { return camera_; }

 private:
  struct Look;
  Look lookAt(const cv::Rect2d& box) const;
  HeadSighting::Status judge(const cv::Rect2d& box, const HeadSighting& sighting) const;

  HeadRangeParams params_;
  Pinhole camera_;
  Eigen::Isometry3d base_from_optical_;
  double pitch_up_rad_;  // of the optical axis
};

}  // namespace frugal_nav
