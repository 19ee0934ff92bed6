#include <algorithm>
#include <cmath>
#include <limits>

#include <embree3/rtcore_ray.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/eval/view_truth.hpp>

namespace frugal_nav::eval {
namespace {

constexpr int kLanes = 8;
// Half axes of the skull of a person 1.75 m tall, upright and front to back, and how it grows with the person
// (sim/people).
constexpr double kHalfHead_m = 0.118;
constexpr double kHalfDepth_m = 0.10;
constexpr double kCommonHeight_m = 1.75;
constexpr double kLeastRows = 1.0;  // a lower box is none

/// Directions (x, y, 1) of all pixels, row by row.
std::vector<cv::Point2d> pixelRays(const Viewpoint& view) {
  std::vector<cv::Point2d> pixels;
  for (int row = 0; row < view.size_px.height; ++row) {
    for (int column = 0; column < view.size_px.width; ++column) pixels.emplace_back(column, row);
  }
  std::vector<cv::Point2d> rays;
  cv::undistortPoints(pixels, rays, view.camera_matrix, view.distortion);
  return rays;
}

/// How much larger a head is than that of a person 1.75 m tall.
double headScale(const sim::PersonBody& body) { return std::sqrt(body.height_m / kCommonHeight_m); }

/// Height of the skull from chin to crown [m].
double skullHeight(const sim::PersonBody& body) { return 2.0 * kHalfHead_m * headScale(body); }

/// The row, counted from the image's upper edge, that shows a point ahead of the camera [px].
double rowOf(const Eigen::Vector3d& p_optical, const Viewpoint& view) {
  const std::vector<cv::Point3d> points{{p_optical.x(), p_optical.y(), p_optical.z()}};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d::zeros(), cv::Vec3d::zeros(), view.camera_matrix, view.distortion,
                    pixels);
  return pixels.front().y + 0.5;  // pixel centres have integer coordinates
}

/// The pixels of one person's head or body and the outline it would have in full view.
struct Region {
  double left = std::numeric_limits<double>::infinity();
  double top = std::numeric_limits<double>::infinity();
  double right = 0.0;
  double bottom = 0.0;
  double pixels = 0.0;

  void add(int column, int row) {
    left = std::min(left, static_cast<double>(column));
    top = std::min(top, static_cast<double>(row));
    right = std::max(right, column + 1.0);
    bottom = std::max(bottom, row + 1.0);
    pixels += 1.0;
  }
};

class PersonView {
 public:
  PersonView(const sim::Scene& scene, const sim::PersonBody& body, const Viewpoint& view)
      : scene_(scene),
        body_(body),
        model_(scene.models[static_cast<std::size_t>(body.model)]),
        view_(view),
        optical_from_world_(view.world_from_optical.inverse()),
        crown_m_(body.height_m - body.neck_height_m),
        chin_m_(crown_m_ - skullHeight(body)) {}

  int model() const { return body_.model; }
  int headMesh() const { return headVisual().mesh; }

  /// Whether a point of the head's mesh lies between chin and crown.
  bool isSkull(const Eigen::Vector3d& p_optical) const {
    const Eigen::Isometry3d world_from_head = model_.world_from_model * headVisual().model_from_visual;
    return isSkullHeight((world_from_head.inverse() * (view_.world_from_optical * p_optical)).z());
  }

  double headDistance_m() const {
    return (middleOfHead() - view_.world_from_optical.translation()).head<2>().norm();
  }

  /// Gives the box of a head's pixels the skull's height: that of an ellipsoid, as HeadRange takes it, across
  /// the line of sight. A head that is partly hidden or outside keeps what is seen of it between these rows.
  void fitToSkull(PersonBox& box) const {
    const Eigen::Vector3d middle = optical_from_world_ * middleOfHead();
    const Eigen::Vector3d up = optical_from_world_.linear() * Eigen::Vector3d::UnitZ();
    const double down_rad = std::atan2(middle.y(), middle.z());
    const double elevation_rad = std::atan2(up.z(), -up.y()) - down_rad;
    const double half_m = headScale(body_) * std::hypot(kHalfHead_m * std::cos(elevation_rad),
                                                        kHalfDepth_m * std::sin(elevation_rad));
    const Eigen::Vector3d across(0.0, -std::cos(down_rad), std::sin(down_rad));
    double top = std::clamp(rowOf(middle + half_m * across, view_), 0.0, 1.0 * view_.size_px.height);
    double bottom = std::clamp(rowOf(middle - half_m * across, view_), 0.0, 1.0 * view_.size_px.height);
    if (box.visible < kWholeHead) {
      top = std::max(top, box.box_px.y);
      bottom = std::min(bottom, box.box_px.y + box.box_px.height);
    }
    if (bottom - top < kLeastRows) return;  // hair alone is seen
    box.box_px.y = top;
    box.box_px.height = bottom - top;
  }

  /// Area of the outline's convex hull in the image's plane, whatever hides it [px^2]; 0 when part of it is
  /// behind the camera.
  double hullArea(bool head_only) const {
    std::vector<cv::Point2f> points;
    for (std::size_t v = 0; v < model_.visuals.size(); ++v) {
      const bool is_head = static_cast<int>(v) == body_.head;
      if (head_only && !is_head) continue;
      const sim::Visual& visual = model_.visuals[v];
      const Eigen::Isometry3d optical_from_mesh =
          optical_from_world_ * model_.world_from_model * visual.model_from_visual;
      for (const Eigen::Vector3f& vertex : scene_.meshes[static_cast<std::size_t>(visual.mesh)].vertices) {
        if (head_only && !isSkullHeight(static_cast<double>(vertex.z()))) continue;
        const Eigen::Vector3d p = optical_from_mesh * vertex.cast<double>();
        constexpr double kNearest_m = 0.05;
        if (p.z() < kNearest_m) return 0.0;
        points.emplace_back(static_cast<float>(view_.camera_matrix(0, 0) * p.x() / p.z()),
                            static_cast<float>(view_.camera_matrix(1, 1) * p.y() / p.z()));
      }
    }
    std::vector<cv::Point2f> hull;
    cv::convexHull(points, hull);
    return cv::contourArea(hull);
  }

  void append(const Region& region, bool is_head, std::vector<PersonBox>& boxes) const {
    const double outline = region.pixels > 0.0 ? hullArea(is_head) : 0.0;
    if (outline <= 0.0) return;
    PersonBox box;
    box.is_head = is_head;
    box.person = body_.person;
    box.box_px = {region.left, region.top, region.right - region.left, region.bottom - region.top};
    box.visible = std::min(1.0, region.pixels / outline);
    box.distance_m = headDistance_m();
    if (is_head) fitToSkull(box);
    boxes.push_back(box);
  }

 private:
  bool isSkullHeight(double z_m) const {
    constexpr double kSlack_m = 0.002;  // the crown itself belongs to it
    return z_m >= chin_m_ && z_m <= crown_m_ + kSlack_m;
  }
  Eigen::Vector3d middleOfHead() const {  // in the world
    return model_.world_from_model * headVisual().model_from_visual *
           Eigen::Vector3d(0.0, 0.0, 0.5 * (chin_m_ + crown_m_));
  }
  const sim::Visual& headVisual() const { return model_.visuals[static_cast<std::size_t>(body_.head)]; }

  const sim::Scene& scene_;
  const sim::PersonBody& body_;
  const sim::Model& model_;
  const Viewpoint& view_;
  Eigen::Isometry3d optical_from_world_;
  // Heights in the frame of the head's visual, which stands at the neck's base [m].
  double crown_m_;
  double chin_m_;
};

RTCRayHit8 packetOf(const std::vector<cv::Point2d>& rays, std::size_t first, const Viewpoint& view,
                    int* active) {
  RTCRayHit8 packet;
  const Eigen::Vector3d origin = view.world_from_optical.translation();
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::size_t i = first + static_cast<std::size_t>(lane);
    active[lane] = i < rays.size() ? -1 : 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    if (active[lane] == 0) continue;
    const Eigen::Vector3d d = view.world_from_optical.linear() * Eigen::Vector3d(rays[i].x, rays[i].y, 1.0);
    packet.ray.org_x[lane] = static_cast<float>(origin.x());
    packet.ray.org_y[lane] = static_cast<float>(origin.y());
    packet.ray.org_z[lane] = static_cast<float>(origin.z());
    packet.ray.dir_x[lane] = static_cast<float>(d.x());
    packet.ray.dir_y[lane] = static_cast<float>(d.y());
    packet.ray.dir_z[lane] = static_cast<float>(d.z());
    packet.ray.tnear[lane] = 0.0F;
    packet.ray.tfar[lane] = std::numeric_limits<float>::infinity();
    packet.ray.time[lane] = 0.0F;
    packet.ray.mask[lane] = ~0U;
    packet.ray.flags[lane] = 0;
  }
  return packet;
}

}  // namespace

ViewTruth traceTruth(const sim::RayTracer& tracer, const Viewpoint& view) {
  ViewTruth truth;
  truth.depth_m = cv::Mat(view.size_px, CV_32FC1, cv::Scalar(std::numeric_limits<double>::infinity()));
  truth.model = cv::Mat(view.size_px, CV_32SC1, cv::Scalar(-1));
  truth.mesh = cv::Mat(view.size_px, CV_32SC1, cv::Scalar(-1));
  const std::vector<cv::Point2d> rays = pixelRays(view);
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    alignas(32) int active[kLanes];
    RTCRayHit8 packet = packetOf(rays, first, view, active);
    tracer.intersect8(active, packet, true);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (active[lane] == 0 || packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
      const int pixel = static_cast<int>(first) + lane;
      const int row = pixel / view.size_px.width;
      const int column = pixel % view.size_px.width;
      const sim::SurfaceHit hit = tracer.resolve(packet, lane);
      truth.depth_m.at<float>(row, column) = packet.ray.tfar[lane];  // directions have z = 1
      truth.model.at<int>(row, column) = hit.model;
      truth.mesh.at<int>(row, column) = hit.mesh;
    }
  }
  return truth;
}

std::vector<PersonBox> findPeople(const ViewTruth& truth, const sim::Scene& scene,
                                  const std::vector<sim::PersonBody>& people, const Viewpoint& view) {
  const std::vector<cv::Point2d> rays = pixelRays(view);
  std::vector<PersonBox> boxes;
  for (const sim::PersonBody& body : people) {
    const PersonView person(scene, body, view);
    Region head;
    Region whole;
    for (int row = 0; row < truth.model.rows; ++row) {
      for (int column = 0; column < truth.model.cols; ++column) {
        if (truth.model.at<int>(row, column) != person.model()) continue;
        whole.add(column, row);
        if (truth.mesh.at<int>(row, column) != person.headMesh()) continue;
        const cv::Point2d& ray = rays[static_cast<std::size_t>(row * truth.model.cols + column)];
        const auto depth = static_cast<double>(truth.depth_m.at<float>(row, column));
        if (person.isSkull(depth * Eigen::Vector3d(ray.x, ray.y, 1.0))) head.add(column, row);
      }
    }
    person.append(head, true, boxes);
    person.append(whole, false, boxes);
  }
  return boxes;
}

}  // namespace frugal_nav::eval
