#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/scene.hpp>

struct RTCRay8;
struct RTCRayHit8;

namespace frugal_nav::sim {

class Surfaces;

/// How the ray tracer computes.
struct RayTracerParams {
  std::string isa = "avx2";

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    visit("isa", isa,
          Field{"", "instruction set of the ray kernels: a fixed one gives the same bytes on every machine",
                -infinity, infinity, "sse2|sse4.2|avx|avx2|default"});
  }
};

/// What a ray met: enough to shade it.
struct SurfaceHit {
  int model = -1;     ///< index into Scene::models
  int mesh = -1;      ///< index into Scene::meshes
  int triangle = -1;  ///< index into the mesh's triangles
  const Eigen::Matrix3f* world_from_mesh_rotation = nullptr;
  const Eigen::Matrix3f* world_from_hit_normal =
      nullptr;  ///< rotates the triangle's normal that Embree gives
};

/// Ray tracing over a scene. What has never moved is one tree of triangles; a model that moves becomes
/// instances of its meshes, so that moving it costs microseconds. Queries are const and may run in parallel.
class RayTracer {
 public:
  /// Builds the trees. The scene must outlive the tracer, and may then change in its models' poses only.
  explicit RayTracer(const Scene& scene, const RayTracerParams& params = {});
  ~RayTracer();
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  /// Reads a model's pose and those of its visuals again; takes effect with commit().
  void updateModel(int model);
  /// Shows or hides a model (the robot that carries the sensors); takes effect with commit().
  void setVisible(int model, bool visible);
  /// Makes the changes visible to rays. No query may run meanwhile.
  void commit();

  /// Distance to the nearest surface along a ray [m]; the direction may have any length. nullopt for nothing
  /// within max_m.
  std::optional<double> range(const Eigen::Vector3d& origin_world, const Eigen::Vector3d& direction_world,
                              double max_m) const;

  /// Nearest hits of eight rays; `active` holds -1 for each ray to trace, 0 for the others. `coherent` says
  /// that the rays run alike. Hits stay as Embree gives them: resolve() names what was met.
  void intersect8(const int* active, RTCRayHit8& rays, bool coherent) const;
  /// Tests eight rays for any hit: a blocked ray's tfar becomes -infinity.
  void occluded8(const int* active, RTCRay8& rays, bool coherent) const;
  /// What the lane of a packet met; the lane must hold a hit.
  SurfaceHit resolve(const RTCRayHit8& rays, int lane) const;

  /// The bounds of one visual in the world [m].
  Eigen::AlignedBox3d visualBounds(int model, int visual) const;
  const Scene& scene() const;
  /// What the user should know (this processor lacks the instruction set asked for); mostly empty.
  const std::string& warning() const;
  const Surfaces& surfaces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav::sim
