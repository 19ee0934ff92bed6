#include "marker_hall.hpp"

#include "camera_room.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>
#include <frugal_nav/perception/marker_sheet.hpp>
#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kMarker_m = 0.20;
constexpr double kBoard_m = 0.30;
constexpr double kBoardDepth_m = 0.03;  // over whatever picture hangs there

/// A marker's frame at a place, its face looking along a yaw: x right, y up, z out of the face.
Eigen::Isometry3d facing(const Eigen::Vector3d& p, double yaw_rad) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(yaw_rad + M_PI_2, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(M_PI_2, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = p;
  return pose;
}

class Builder {
 public:
  Builder(const std::vector<sim::Texture>& textures, Random& random)
      : random_(random), room_(textures, random, hall_.scene) {}

  /// Nothing when the draw did not work out.
  std::optional<MarkerHall> build(double disc_radius_m, int waypoints) {
    const double length = random_.uniform(6.0, 9.0);
    const double width = random_.uniform(5.0, 7.0);
    floor_ = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(length, width)};
    room_.build(floor_, std::nullopt);
    hall_.scene.name = "marker hall";
    addPillars();
    constexpr double kNone_m = 1e3;  // no lane and no partition to keep free
    room_.furnish(-kNone_m, kNone_m, -kNone_m, kNone_m);
    addMarkers();
    constexpr const char* kLights[] = {"daylight", "dim", "tube"};
    hall_.light = kLights[random_.integer(0, 2)];
    if (!drawTour(disc_radius_m, waypoints)) return std::nullopt;
    return std::move(hall_);
  }

 private:
  void addPillars() {
    const int pillars = random_.integer(2, 4);
    for (int i = 0; i < pillars; ++i) {
      const Eigen::Vector2d share((0.5 + (i % 2)) / 2.0, (0.5 + i / 2) / (pillars > 2 ? 2.0 : 1.0));
      const Eigen::Vector2d p = share.cwiseProduct(floor_.sizes()) +
                                Eigen::Vector2d(random_.uniform(-0.5, 0.5), random_.uniform(-0.5, 0.5));
      pillars_.push_back(
          {{p.x(), p.y(), 0.0}, Eigen::Vector2d::Constant(random_.uniform(0.3, 0.5)), 0.0, false});
      room_.addPillar(p, pillars_.back().size_m.x());
    }
  }

  void addMarkers() {
    for (const Solid& pillar : pillars_) {
      for (int side = 0; side < 4; ++side)
        addMarker(pillar.world_from_solid.position(), side * M_PI_2, 0.5 * pillar.size_m.x());
    }
    for (int side = 0; side < 4; ++side) {
      const double yaw = side * M_PI_2;  // a wall's markers look inward
      const bool along_y = side % 2 == 0;
      const double from = along_y ? floor_.min().y() : floor_.min().x();
      const double to = along_y ? floor_.max().y() : floor_.max().x();
      for (double at = from + random_.uniform(0.4, 0.9); at < to - 0.4; at += random_.uniform(1.2, 2.0)) {
        const Eigen::Vector2d p = along_y
                                      ? Eigen::Vector2d(side == 0 ? floor_.min().x() : floor_.max().x(), at)
                                      : Eigen::Vector2d(at, side == 1 ? floor_.min().y() : floor_.max().y());
        addMarker(p, yaw, 0.0);
      }
    }
  }

  /// Hangs the next marker before a surface, unless something stands in front of it.
  void addMarker(const Eigen::Vector2d& p, double yaw, double off_m) {
    const Eigen::Vector2d out(std::cos(yaw), std::sin(yaw));
    const double height = random_.uniform(0.42, 0.6);
    constexpr double kClear_m = 0.45;
    const Eigen::Vector2d front = p + (off_m + kClear_m) * out;
    const bool is_hidden = std::any_of(room_.solids.begin(), room_.solids.end(), [&](const Solid& solid) {
      return !solid.overhang && solid.distanceTo(front) < 0.9 * kClear_m;
    });
    const int id = static_cast<int>(hall_.map.markers.size());
    const int ids = MarkerDictionary(hall_.map.dictionary).count();
    if (is_hidden || id >= ids) return;
    const Eigen::Vector2d at = p + (off_m + kBoardDepth_m + 0.002) * out;
    MappedMarker& marker = hall_.map.markers[id];
    marker = {id, kMarker_m, facing({at.x(), at.y(), height}, yaw)};
    hangMarker(marker, hall_.map.dictionary, "marker_" + std::to_string(id), hall_.scene);
  }

  bool drawTour(double disc_radius_m, int waypoints) {
    const FreeSpace space(floor_, room_.solids, disc_radius_m);
    const auto draw = [&]() {
      const Eigen::Vector2d unit(random_.uniform(0.0, 1.0), random_.uniform(0.0, 1.0));
      return Eigen::Vector2d(floor_.min() + unit.cwiseProduct(floor_.sizes()));
    };
    constexpr int kAttempts = 200;
    constexpr double kApart_m = 2.0;
    std::optional<Eigen::Vector2d> last;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Eigen::Vector2d p = draw();
      if (!space.isFree(p)) continue;
      if (!last) {
        if (!startAt(p)) continue;
      } else {
        const std::optional<double> way = space.pathLength(*last, p);
        if (!way || *way < kApart_m) continue;
        hall_.waypoints.push_back(p);
        hall_.tour_m += *way;
        if (static_cast<int>(hall_.waypoints.size()) == waypoints) return true;
      }
      last = p;
    }
    return false;
  }

  /// Looks at a marker from there, if one hangs well in view.
  bool startAt(const Eigen::Vector2d& p) {
    constexpr double kNearest_m = 0.8;
    constexpr double kFarthest_m = 2.2;
    for (const auto& [id, marker] : hall_.map.markers) {
      const Eigen::Vector2d to_marker = marker.map_from_marker.translation().head<2>() - p;
      const double facing = -to_marker.normalized().dot(marker.map_from_marker.linear().col(2).head<2>());
      if (to_marker.norm() < kNearest_m || to_marker.norm() > kFarthest_m || facing < std::cos(0.9)) continue;
      const bool is_clear = std::none_of(room_.solids.begin(), room_.solids.end(), [&](const Solid& solid) {
        return solid.distanceTo(p + 0.5 * to_marker) < 0.3;
      });
      if (!is_clear) continue;
      hall_.start = {p.x(), p.y(), std::atan2(to_marker.y(), to_marker.x()) + random_.uniform(-0.25, 0.25)};
      return true;
    }
    return false;
  }

  Random& random_;
  MarkerHall hall_;
  CameraRoom room_;
  Eigen::AlignedBox2d floor_;
  std::vector<Solid> pillars_;
};

}  // namespace

MarkerHall makeMarkerHall(std::uint64_t seed, double disc_radius_m, int waypoints,
                          const std::vector<sim::Texture>& textures) {
  Random random(seed, "marker hall");
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (auto hall = Builder(textures, random).build(disc_radius_m, waypoints)) return *hall;
  }
  throw std::runtime_error("no hall could be drawn from the seed " + std::to_string(seed));
}

void hangMarker(const MappedMarker& marker, const std::string& dictionary, const std::string& name,
                sim::Scene& scene) {
  constexpr int kCell_px = 32;
  const MarkerDictionary printed(dictionary);
  const cv::Mat image = markerTexture(printed, marker.id, kCell_px);
  sim::Texture texture{name, image.cols, image.rows, {}};
  for (const auto grey : cv::Mat_<unsigned char>(image)) texture.rgb.insert(texture.rgb.end(), 3, grey);
  scene.textures.push_back(std::move(texture));
  sim::Material paper;
  paper.name = name;
  paper.albedo = Eigen::Vector3f::Constant(0.92F);
  scene.materials.push_back(paper);  // the board
  paper.texture = static_cast<int>(scene.textures.size()) - 1;
  scene.materials.push_back(paper);

  sim::Model model;
  model.name = name;
  model.world_from_model = marker.map_from_marker;
  const auto add = [&](sim::Mesh mesh, int material, double z) {
    mesh.triangle_material.assign(mesh.triangles.size(), material);
    Eigen::Isometry3d model_from_visual = Eigen::Isometry3d::Identity();
    model_from_visual.translation().z() = z;
    model.visuals.push_back({static_cast<int>(scene.meshes.size()), model_from_visual});
    scene.meshes.push_back(std::move(mesh));
  };
  const int materials = static_cast<int>(scene.materials.size());
  const double side = markerTextureSide_m(printed, marker.size_m);
  add(sim::makePlane({side, side}, Eigen::Vector3d::UnitZ()), materials - 1, 0.0);
  const double board = std::max(kBoard_m, side);
  add(sim::makeBox({board, board, kBoardDepth_m}), materials - 2, -0.5 * kBoardDepth_m - 0.0015);
  scene.models.push_back(std::move(model));
}

bool isInView(const MappedMarker& marker, const Pinhole& camera, const Eigen::Isometry3d& map_from_optical,
              double max_range_m, const sim::RayTracer& tracer) {
  const Eigen::Vector3d eye = map_from_optical.translation();
  const Eigen::Vector3d line = marker.map_from_marker.translation() - eye;
  if (line.norm() > max_range_m) return false;
  constexpr double kLeastFacing = 0.5;  // the cosine of 60 degrees
  if (-line.normalized().dot(marker.map_from_marker.linear().col(2)) < kLeastFacing) return false;
  constexpr double kBorder_m = 0.02;  // some white is needed, too
  for (const Eigen::Vector3d& corner : markerCorners(marker.size_m + 2.0 * kBorder_m)) {
    const Eigen::Vector3d p = marker.map_from_marker * corner;
    const auto pixel = camera.project(map_from_optical.inverse() * p);
    if (!pixel || pixel->minCoeff() < 0.0 || pixel->x() > camera.width_px - 1 ||
        pixel->y() > camera.height_px - 1)
      return false;
    constexpr double kBefore_m = 0.02;
    if (tracer.range(eye, p - eye, (p - eye).norm() - kBefore_m)) return false;
  }
  return true;
}

}  // namespace frugal_nav::eval
