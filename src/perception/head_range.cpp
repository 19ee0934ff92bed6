#include <algorithm>
#include <cmath>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/perception/head_range.hpp>

namespace frugal_nav {
namespace {

constexpr double kHalfPerson_m = 0.3;  // half the width of a whole person, where the box holds one

}  // namespace

/// A box on the plane at distance one: centre (x, y) and height h, with their derivatives by the box's centre
/// column, top and bottom.
struct HeadRange::Look {
  bool found = false;
  double x = 0.0;
  double y = 0.0;
  double h = 0.0;
  Eigen::Matrix3d by_box = Eigen::Matrix3d::Zero();
};

HeadRange::HeadRange(const HeadRangeParams& params, const Pinhole& camera,
                     const Eigen::Isometry3d& base_from_optical)
    : params_(params), camera_(camera), base_from_optical_(base_from_optical) {
  validate(params, "head range");
  const std::string fault = camera.fault();
  if (!fault.empty()) throw ConfigError(fault);
  const Eigen::Vector3d up_optical = base_from_optical.linear().transpose() * Eigen::Vector3d::UnitZ();
  pitch_up_rad_ = std::atan2(up_optical.z(), -up_optical.y());
}

HeadRange::Look HeadRange::lookAt(const cv::Rect2d& box) const {
  // The box counts from the image's edge, the camera from the centre of the first pixel.
  const double u = box.x + 0.5 * box.width - 0.5;
  const double top = box.y - 0.5;
  const double bottom = top + box.height;
  const auto upper = camera_.lookThrough({u, top});
  const auto lower = camera_.lookThrough({u, bottom});
  const auto centre = camera_.lookThrough({u, 0.5 * (top + bottom)});
  Look look;
  if (!upper || !lower || !centre) return look;
  look.found = true;
  look.x = centre->point.x();
  look.y = centre->point.y();
  look.h = lower->point.y() - upper->point.y();
  const Eigen::Matrix2d& c = centre->jacobian;
  look.by_box << c(0, 0), 0.5 * c(0, 1), 0.5 * c(0, 1),  //
      c(1, 0), 0.5 * c(1, 1), 0.5 * c(1, 1),             //
      lower->jacobian(1, 0) - upper->jacobian(1, 0), -upper->jacobian(1, 1), lower->jacobian(1, 1);
  return look;
}

HeadSighting HeadRange::locate(const Detection& head) const {
  HeadSighting sighting;
  sighting.class_id = head.class_id;
  sighting.score = head.score;
  const cv::Rect2d& box = head.box;
  if (!std::isfinite(box.x + box.y + box.width + box.height) || !(box.height > 0.0)) return sighting;
  const Look look = lookAt(box);
  if (!look.found || !(look.h > 0.0)) return sighting;

  const double stretch = 1.0 + look.y * look.y;
  const double elevation = pitch_up_rad_ - std::atan(look.y);
  const double tall = params_.head_height_m * params_.head_height_m;
  const double deep = params_.head_depth_m * params_.head_depth_m;
  const double extent =
      std::sqrt(tall * std::pow(std::cos(elevation), 2) + deep * std::pow(std::sin(elevation), 2));
  const double depth = std::sqrt(stretch) * extent / look.h;

  // d extent / d elevation = (deep - tall) sin e cos e / extent, and d elevation / dy = -1 / (1 + y^2).
  const double extent_slope = (deep - tall) * std::sin(elevation) * std::cos(elevation) / extent;
  const double depth_by_y = depth * (look.y / stretch - extent_slope / (extent * stretch));
  const double depth_by_h = -depth / look.h;
  const Eigen::Vector3d direction(look.x, look.y, 1.0);
  Eigen::Matrix3d by_look;  // of the point in the optical frame by (x, y, h)
  by_look.col(0) = depth * Eigen::Vector3d::UnitX();
  by_look.col(1) = depth * Eigen::Vector3d::UnitY() + depth_by_y * direction;
  by_look.col(2) = depth_by_h * direction;

  sighting.from_eye_m = base_from_optical_.linear() * (depth * direction);
  const Eigen::Vector3d p = base_from_optical_.translation() + sighting.from_eye_m;
  sighting.p_base = p.head<2>();
  sighting.above_floor_m = p.z();
  sighting.range_m = sighting.p_base.norm();
  sighting.bearing_rad = std::atan2(p.y(), p.x());
  sighting.place_by_box = base_from_optical_.linear() * by_look * look.by_box;
  sighting.size_sigma = params_.head_height_share;

  const double edge_px = std::hypot(params_.edge_noise_px, params_.edge_noise_share * box.height);
  const Eigen::Vector3d variances(0.5 * edge_px * edge_px, edge_px * edge_px, edge_px * edge_px);
  const double aside_m = params_.direction_noise_rad * sighting.from_eye_m.norm();
  sighting.noise_m2 = sighting.place_by_box * variances.asDiagonal() * sighting.place_by_box.transpose() +
                      aside_m * aside_m * Eigen::Matrix3d::Identity();

  sighting.status = judge(box, sighting);
  return sighting;
}

HeadSighting::Status HeadRange::judge(const cv::Rect2d& box, const HeadSighting& sighting) const {
  using Status = HeadSighting::Status;
  const double border = std::max(params_.border_px, params_.border_share * box.height);
  const bool is_whole = box.x >= border && box.y >= border &&
                        box.x + box.width <= camera_.width_px - border &&
                        box.y + box.height <= camera_.height_px - border;
  if (!is_whole) return Status::kCutOff;
  if (box.height < params_.min_box_px) return Status::kTooSmall;
  if (sighting.range_m > params_.max_range_m) return Status::kTooFar;
  const bool is_head_high = sighting.above_floor_m >= params_.min_above_floor_m &&
                            sighting.above_floor_m <= params_.max_above_floor_m;
  return is_head_high ? Status::kGood : Status::kImplausible;
}

bool HeadRange::couldSee(const Eigen::Vector2d& p_base, double above_floor_m) const {
  const Eigen::Isometry3d optical_from_base = base_from_optical_.inverse();
  const double half = (0.5 + params_.border_share) * std::max(params_.head_height_m, params_.head_depth_m);
  const double slack = params_.border_px;
  for (const double above : {above_floor_m - half, above_floor_m + half}) {
    const Eigen::Vector3d p = optical_from_base * Eigen::Vector3d(p_base.x(), p_base.y(), above);
    if (!(p.z() > 0.0)) return false;
    // The width of the head stands in the image's plane, whatever its bearing.
    const double half_width = std::min(half, kHalfPerson_m);
    for (const double aside : {-half_width, half_width}) {
      const auto pixel = camera_.project(p + Eigen::Vector3d(aside, 0.0, 0.0));
      const bool inside = pixel && pixel->x() > slack && pixel->x() < camera_.width_px - 1 - slack &&
                          pixel->y() > slack && pixel->y() < camera_.height_px - 1 - slack;
      if (!inside) return false;
    }
  }
  return true;
}

const char* toText(HeadSighting::Status status) {
  switch (status) {
    case HeadSighting::Status::kGood:
      return "good";
    case HeadSighting::Status::kNotFinite:
      return "the box is not finite";
    case HeadSighting::Status::kCutOff:
      return "the head is cut off by the image's edge";
    case HeadSighting::Status::kTooSmall:
      return "the box is too small for a distance";
    case HeadSighting::Status::kTooFar:
      return "the head is too far away";
    case HeadSighting::Status::kImplausible:
      return "no head is that far above the floor";
  }
  return "";
}

}  // namespace frugal_nav
