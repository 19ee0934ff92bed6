#include "flush_to_zero.hpp"
#include "surfaces.hpp"
#include "triangle_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include <embree3/rtcore.h>

#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {
namespace {

// One thread: several split the tree in an order of their own, and equal distances then go to either
// triangle.
constexpr const char* kDeviceOptions = "threads=1,start_threads=0,set_affinity=0";

const Eigen::Matrix3f kIdentity = Eigen::Matrix3f::Identity();

bool processorHas(const std::string& isa) {
#if defined(__x86_64__) || defined(__i386__)
  if (isa == "avx2") return __builtin_cpu_supports("avx2") != 0;
  if (isa == "avx") return __builtin_cpu_supports("avx") != 0;
  if (isa == "sse4.2") return __builtin_cpu_supports("sse4.2") != 0;
#endif
  return true;
}

Eigen::Isometry3d worldFromVisual(const Model& model, const Visual& visual) {
  return model.world_from_model * visual.model_from_visual;
}

}  // namespace

struct RayTracer::Impl {
  /// One visual: part of the tree of what never moved, or an instance of its mesh's tree.
  struct Part {
    int model = -1;
    int visual = -1;
    int mesh = -1;
    unsigned static_id = RTC_INVALID_GEOMETRY_ID;
    unsigned instance_id = RTC_INVALID_GEOMETRY_ID;
    Eigen::Matrix3f world_from_mesh = Eigen::Matrix3f::Identity();
  };

  Impl(const Scene& scene_in, const RayTracerParams& params);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void addStatic(Part& part);
  void promote(int model);
  void placeInstance(const Part& part, const Eigen::Isometry3d& pose);
  RTCScene meshScene(int mesh);
  const Visual& visualOf(const Part& part) const {
    return scene.models[static_cast<std::size_t>(part.model)].visuals[static_cast<std::size_t>(part.visual)];
  }

  const Scene& scene;
  std::once_flag
      surfaces_made;  // by the first image: a laser needs no textures, and their pyramids take a second
  std::unique_ptr<Surfaces> surfaces;
  std::string warning;
  RTCDevice device = nullptr;
  RTCScene still = nullptr;  // everything that has never moved
  RTCScene top = nullptr;    // an instance of `still`, and one of each visual that moved
  RTCScene root = nullptr;   // what rays start in: `still` while nothing has moved
  std::vector<Part> parts;
  std::vector<std::pair<std::size_t, std::size_t>> parts_of_model;  // [first, last) in `parts`
  std::vector<bool> moves;                                          // by model
  std::vector<bool> visible;                                        // by model
  std::vector<RTCScene> mesh_scenes;                                // by mesh, made when first needed
  std::vector<std::size_t> part_of_static;                          // by geometry in `still`
  std::vector<std::size_t> part_of_instance;                        // by geometry in `top`, from 1
  std::vector<Eigen::Isometry3d> poses;                             // world_from_visual last read, by part
  bool still_changed = true;
  bool top_changed = true;
};

RayTracer::Impl::Impl(const Scene& scene_in, const RayTracerParams& params) : scene(scene_in) {
  validate(params, "ray tracer");
  std::string options = kDeviceOptions;
  if (!processorHas(params.isa)) {
    warning = "this processor lacks " + params.isa + ": rays differ in their last bits from other machines'";
  } else if (params.isa != "default") {
    options += ",isa=" + params.isa;
  }
  device = rtcNewDevice(options.c_str());
  if (device == nullptr) throw ConfigError("Embree cannot start with '" + options + "'");
  still = rtcNewScene(device);
  top = rtcNewScene(device);
  rtcSetSceneFlags(still, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneFlags(top, RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(top, RTC_BUILD_QUALITY_LOW);
  mesh_scenes.resize(scene.meshes.size(), nullptr);
  moves.resize(scene.models.size(), false);
  visible.resize(scene.models.size(), true);
  for (std::size_t m = 0; m < scene.models.size(); ++m) {
    const std::size_t first = parts.size();
    for (std::size_t v = 0; v < scene.models[m].visuals.size(); ++v) {
      const Visual& visual = scene.models[m].visuals[v];
      checkMesh(scene, scene.models[m], visual);
      if (scene.meshes[static_cast<std::size_t>(visual.mesh)].triangles.empty()) continue;
      Part part;
      part.model = static_cast<int>(m);
      part.visual = static_cast<int>(v);
      part.mesh = visual.mesh;
      parts.push_back(part);
      addStatic(parts.back());
    }
    parts_of_model.emplace_back(first, parts.size());
  }
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, still);
  rtcCommitGeometry(instance);
  rtcAttachGeometryByID(top, instance, 0);
  rtcReleaseGeometry(instance);
}

RayTracer::Impl::~Impl() {
  rtcReleaseScene(top);
  for (RTCScene mesh_scene : mesh_scenes) {
    if (mesh_scene != nullptr) rtcReleaseScene(mesh_scene);
  }
  rtcReleaseScene(still);
  rtcReleaseDevice(device);
}

void RayTracer::Impl::addStatic(Part& part) {
  const Eigen::Isometry3d pose =
      worldFromVisual(scene.models[static_cast<std::size_t>(part.model)], visualOf(part));
  RTCGeometry geometry = makeGeometry(device, scene.meshes[static_cast<std::size_t>(part.mesh)], pose);
  part.static_id = static_cast<unsigned>(part_of_static.size());
  part.world_from_mesh = pose.linear().cast<float>();
  rtcAttachGeometryByID(still, geometry, part.static_id);
  rtcReleaseGeometry(geometry);
  part_of_static.push_back(parts.size() - 1);
  poses.push_back(pose);
}

/// Takes a model out of the tree of still things and makes each of its visuals an instance.
void RayTracer::Impl::promote(int model) {
  const auto [first, last] = parts_of_model[static_cast<std::size_t>(model)];
  for (std::size_t p = first; p < last; ++p) {
    Part& part = parts[p];
    rtcDetachGeometry(still, part.static_id);
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, meshScene(part.mesh));
    part_of_instance.push_back(p);
    part.instance_id = static_cast<unsigned>(part_of_instance.size());
    rtcAttachGeometryByID(top, instance, part.instance_id);
    if (!visible[static_cast<std::size_t>(model)]) rtcDisableGeometry(instance);
    rtcReleaseGeometry(instance);
    still_changed = true;
  }
  moves[static_cast<std::size_t>(model)] = true;
}

void RayTracer::Impl::placeInstance(const Part& part, const Eigen::Isometry3d& pose) {
  const Eigen::Matrix4f matrix = pose.matrix().cast<float>();
  RTCGeometry instance = rtcGetGeometry(top, part.instance_id);
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, matrix.data());
  rtcCommitGeometry(instance);
  top_changed = true;
}

RTCScene RayTracer::Impl::meshScene(int mesh) {
  RTCScene& made = mesh_scenes[static_cast<std::size_t>(mesh)];
  if (made == nullptr) {
    made = rtcNewScene(device);
    rtcSetSceneFlags(made, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry =
        makeGeometry(device, scene.meshes[static_cast<std::size_t>(mesh)], Eigen::Isometry3d::Identity());
    rtcAttachGeometry(made, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(made);
  }
  return made;
}

RayTracer::RayTracer(const Scene& scene, const RayTracerParams& params)
    : impl_(std::make_unique<Impl>(scene, params)) {
  commit();
}

RayTracer::~RayTracer() = default;

void RayTracer::updateModel(int model) {
  const auto m = static_cast<std::size_t>(model);
  const auto [first, last] = impl_->parts_of_model.at(m);
  for (std::size_t p = first; p < last; ++p) {
    Impl::Part& part = impl_->parts[p];
    const Eigen::Isometry3d pose = worldFromVisual(impl_->scene.models[m], impl_->visualOf(part));
    if (impl_->moves[m] && pose.matrix() == impl_->poses[p].matrix()) continue;
    if (!impl_->moves[m]) {
      if (pose.matrix() == impl_->poses[p].matrix()) continue;
      impl_->promote(model);
      for (std::size_t q = first; q < last; ++q) impl_->placeInstance(impl_->parts[q], impl_->poses[q]);
    }
    impl_->poses[p] = pose;
    part.world_from_mesh = pose.linear().cast<float>();
    impl_->placeInstance(part, pose);
  }
}

void RayTracer::setVisible(int model, bool visible) {
  const auto m = static_cast<std::size_t>(model);
  const auto [first, last] = impl_->parts_of_model.at(m);
  if (impl_->visible[m] == visible) return;
  impl_->visible[m] = visible;
  for (std::size_t p = first; p < last; ++p) {
    const Impl::Part& part = impl_->parts[p];
    RTCGeometry geometry = impl_->moves[m] ? rtcGetGeometry(impl_->top, part.instance_id)
                                           : rtcGetGeometry(impl_->still, part.static_id);
    if (visible) {
      rtcEnableGeometry(geometry);
    } else {
      rtcDisableGeometry(geometry);
    }
  }
  (impl_->moves[m] ? impl_->top_changed : impl_->still_changed) = true;
}

void RayTracer::commit() {
  if (impl_->still_changed) {
    rtcCommitScene(impl_->still);
    rtcCommitGeometry(rtcGetGeometry(impl_->top, 0));
    impl_->top_changed = true;
  }
  if (impl_->top_changed) rtcCommitScene(impl_->top);
  impl_->still_changed = impl_->top_changed = false;
  impl_->root = impl_->part_of_instance.empty() ? impl_->still : impl_->top;
}

std::optional<double> RayTracer::range(const Eigen::Vector3d& origin_world,
                                       const Eigen::Vector3d& direction_world, double max_m) const {
  const FlushToZero flush;
  const Eigen::Vector3f o = origin_world.cast<float>();
  const Eigen::Vector3f d = direction_world.normalized().cast<float>();
  RTCRayHit ray{};
  ray.ray.org_x = o.x();
  ray.ray.org_y = o.y();
  ray.ray.org_z = o.z();
  ray.ray.dir_x = d.x();
  ray.ray.dir_y = d.y();
  ray.ray.dir_z = d.z();
  ray.ray.tfar = static_cast<float>(max_m);
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->root, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return static_cast<double>(ray.ray.tfar);
}

void RayTracer::intersect8(const int* active, RTCRayHit8& rays, bool coherent) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcIntersect8(active, impl_->root, &context, &rays);
}

void RayTracer::occluded8(const int* active, RTCRay8& rays, bool coherent) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded8(active, impl_->root, &context, &rays);
}

SurfaceHit RayTracer::resolve(const RTCRayHit8& rays, int lane) const {
  const unsigned instance = rays.hit.instID[0][lane];
  const bool still = instance == RTC_INVALID_GEOMETRY_ID || instance == 0;
  const std::size_t p =
      still ? impl_->part_of_static[rays.hit.geomID[lane]] : impl_->part_of_instance[instance - 1];
  const Impl::Part& part = impl_->parts[p];
  SurfaceHit hit;
  hit.model = part.model;
  hit.mesh = part.mesh;
  hit.triangle = static_cast<int>(rays.hit.primID[lane]);
  hit.world_from_mesh_rotation = &part.world_from_mesh;
  hit.world_from_hit_normal = still ? &kIdentity : &part.world_from_mesh;
  return hit;
}

Eigen::AlignedBox3d RayTracer::visualBounds(int model, int visual) const {
  const Model& owner = impl_->scene.models.at(static_cast<std::size_t>(model));
  const Visual& drawn = owner.visuals.at(static_cast<std::size_t>(visual));
  const Eigen::Isometry3d pose = worldFromVisual(owner, drawn);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& vertex :
       impl_->scene.meshes.at(static_cast<std::size_t>(drawn.mesh)).vertices) {
    box.extend(pose * vertex.cast<double>());
  }
  return box;
}

const Scene& RayTracer::scene() const { return impl_->scene; }
const Surfaces& RayTracer::surfaces() const {
  std::call_once(impl_->surfaces_made,
                 [this] { impl_->surfaces = std::make_unique<Surfaces>(impl_->scene); });
  return *impl_->surfaces;
}
const std::string& RayTracer::warning() const { return impl_->warning; }

}  // namespace frugal_nav::sim
