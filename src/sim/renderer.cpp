#include "renderer.hpp"

#include "shading.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <embree3/rtcore_ray.h>

namespace frugal_nav::sim {
namespace {

constexpr int kTile = 16;
// A packet is 4 x 2 pixels: nearer to a square than 8 x 1, so its rays run closer together.
constexpr int kPacketWidth = 4;
constexpr int kPacketHeight = 2;
constexpr float kEmissionOverWhite = 3.0F;  // a lamp is brighter than the white paper it lights
constexpr float kNothing = std::numeric_limits<float>::infinity();

/// The pose of the camera as the inner loops need it.
struct Eye {
  explicit Eye(const Eigen::Isometry3d& world_from_optical)
      : position(world_from_optical.translation().cast<float>()),
        rotation(world_from_optical.linear().cast<float>()) {}
  Eigen::Vector3f position;
  Eigen::Matrix3f rotation;
};

/// The eight pixels of a packet, from its top left.
struct Packet {
  int column = 0;
  int row = 0;
  int columnOf(int lane) const { return column + lane % kPacketWidth; }
  int rowOf(int lane) const { return row + lane / kPacketWidth; }
};

class TileRenderer {
 public:
  TileRenderer(const View& view, const std::vector<Eye>& eyes, bool with_depth, LightImage& image)
      : view_(view),
        surfaces_(view.tracer.surfaces()),
        eyes_(eyes),
        with_depth_(with_depth),
        image_(image),
        background_lx_(view.tracer.scene().background.unaryExpr(&linearFromSrgb) *
                       static_cast<float>(view.lighting.illuminance_lx())),
        lamp_lx_(kEmissionOverWhite * static_cast<float>(view.lighting.illuminance_lx())) {}

  void render(int tile_column, int tile_row) const {
    for (int y = 0; y < kTile; y += kPacketHeight) {
      for (int x = 0; x < kTile; x += kPacketWidth) {
        const Packet packet{tile_column * kTile + x, tile_row * kTile + y};
        if (packet.column < view_.lens.width() && packet.row < view_.lens.height()) renderPacket(packet);
      }
    }
  }

 private:
  std::size_t pixel(const Packet& packet, int lane) const {
    return static_cast<std::size_t>(packet.rowOf(lane)) * static_cast<std::size_t>(view_.lens.width()) +
           static_cast<std::size_t>(packet.columnOf(lane));
  }
  bool inside(const Packet& packet, int lane) const {
    return packet.columnOf(lane) < view_.lens.width() && packet.rowOf(lane) < view_.lens.height();
  }

  void renderPacket(const Packet& packet) const {
    const float weight = 1.0F / static_cast<float>(eyes_.size());
    Lanes3 sum = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};
    for (std::size_t s = 0; s < eyes_.size(); ++s) {
      const bool depth_here = with_depth_ && s == eyes_.size() / 2;
      const Lanes3 seen = look(packet, eyes_[s], depth_here);
      for (std::size_t i = 0; i < 3; ++i) sum[i] += seen[i];
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      if (inside(packet, lane)) {
        image_.light_lx[pixel(packet, lane)] = weight * getLane(sum, lane);
      }
    }
  }

  /// Light that eight pixels see from one eye.
  Lanes3 look(const Packet& packet, const Eye& eye, bool with_depth) const {
    alignas(32) int active[kLanes] = {};
    RTCRayHit8 rays;
    for (int lane = 0; lane < kLanes; ++lane) {
      rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      if (inside(packet, lane)) {
        active[lane] = -1;
        setRay(packet, eye, lane, rays);
      }
    }
    view_.tracer.intersect8(active, rays, true);
    return shade(packet, active, rays, with_depth);
  }

  void setRay(const Packet& packet, const Eye& eye, int lane, RTCRayHit8& rays) const {
    const Eigen::Vector3f direction =
        eye.rotation * Eigen::Vector3f(view_.lens.rayX(packet.columnOf(lane), packet.rowOf(lane)),
                                       view_.lens.rayY(packet.columnOf(lane), packet.rowOf(lane)), 1.0F);
    rays.ray.org_x[lane] = eye.position.x();
    rays.ray.org_y[lane] = eye.position.y();
    rays.ray.org_z[lane] = eye.position.z();
    rays.ray.dir_x[lane] = direction.x();
    rays.ray.dir_y[lane] = direction.y();
    rays.ray.dir_z[lane] = direction.z();
    rays.ray.tnear[lane] = 0.0F;
    rays.ray.tfar[lane] = kNothing;
    rays.ray.time[lane] = 0.0F;
    rays.ray.mask[lane] = ~0U;
    rays.ray.flags[lane] = 0;
    rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }

  Lanes3 shade(const Packet& packet, const int* active, const RTCRayHit8& rays, bool with_depth) const {
    ShadePoints points;
    std::array<SurfacePoint, kLanes> surfaces;
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      points.active[i] = rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      if (!points.active[i]) {
        setLane(points.position, lane, Eigen::Vector3f::Zero());  // keeps the arithmetic of all lanes defined
        setLane(points.normal, lane, Eigen::Vector3f::UnitZ());
        if (with_depth && active[lane] != 0) storeDepth(packet, lane, kNothing, 0.0F);
        continue;
      }
      const float depth = rays.ray.tfar[lane];
      const Eigen::Vector3f origin(rays.ray.org_x[lane], rays.ray.org_y[lane], rays.ray.org_z[lane]);
      const Eigen::Vector3f direction(rays.ray.dir_x[lane], rays.ray.dir_y[lane], rays.ray.dir_z[lane]);
      surfaces[i] = surfaces_.at(view_.tracer.resolve(rays, lane), rays, lane, depth / view_.lens.focal_px());
      setLane(points.position, lane, origin + depth * direction);
      setLane(points.normal, lane, surfaces[i].normal_world);
      setLane(points.face_normal, lane, surfaces[i].face_normal);
      if (with_depth) {
        storeDepth(packet, lane, depth, -surfaces[i].face_normal.dot(direction) / direction.norm());
      }
    }
    Lanes3 light = illuminate(view_.tracer, view_.lighting, points);
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      const Eigen::Vector3f reflected = getLane(light, lane);
      setLane(light, lane,
              points.active[i] ? Eigen::Vector3f(reflected.cwiseProduct(surfaces[i].albedo) +
                                                 lamp_lx_ * surfaces[i].emission)
                               : background_lx_);
    }
    return light;
  }

  void storeDepth(const Packet& packet, int lane, float depth_m, float cos_incidence) const {
    image_.depth_m[pixel(packet, lane)] = depth_m;
    image_.cos_incidence[pixel(packet, lane)] = cos_incidence;
  }

  const View& view_;
  const Surfaces& surfaces_;
  const std::vector<Eye>& eyes_;
  bool with_depth_;
  LightImage& image_;
  Eigen::Vector3f background_lx_;
  float lamp_lx_;
};

}  // namespace

void renderLight(const View& view, const std::vector<Eigen::Isometry3d>& world_from_optical, bool with_depth,
                 WorkerPool& pool, LightImage& image) {
  const auto pixels =
      static_cast<std::size_t>(view.lens.width()) * static_cast<std::size_t>(view.lens.height());
  image.light_lx.resize(pixels);
  image.depth_m.resize(with_depth ? pixels : 0);
  image.cos_incidence.resize(with_depth ? pixels : 0);
  std::vector<Eye> eyes;
  for (const Eigen::Isometry3d& pose : world_from_optical) eyes.emplace_back(pose);
  const TileRenderer renderer(view, eyes, with_depth, image);
  const int columns = (view.lens.width() + kTile - 1) / kTile;
  const int rows = (view.lens.height() + kTile - 1) / kTile;
  pool.run(columns * rows, [&](int tile) { renderer.render(tile % columns, tile / columns); });
}

}  // namespace frugal_nav::sim
