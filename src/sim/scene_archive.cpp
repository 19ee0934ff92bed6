#include <cstring>
#include <type_traits>
#include <vector>

#include <frugal_nav/sim/scene_archive.hpp>

namespace frugal_nav::sim {
namespace {

/// Appends values to a text of bytes.
class Writer {
 public:
  template <class T>
  using Ref = const T&;

  void raw(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  template <class T>
  std::size_t count(const T& container) {
    const std::uint64_t size = container.size();
    raw(&size, sizeof(size));
    return container.size();
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Takes values from bytes in the order in which the Writer put them; reads zeros past the end.
class Reader {
 public:
  template <class T>
  using Ref = T&;

  explicit Reader(const std::string& bytes) : next_(bytes.data()), left_(bytes.size()) {}

  void raw(void* data, std::size_t size) {
    if (size > left_) {
      is_sound_ = false;
      left_ = 0;
      std::memset(data, 0, size);
      return;
    }
    if (size > 0) std::memcpy(data, next_, size);
    next_ += size;
    left_ -= size;
  }
  template <class T>
  std::size_t count(T& container) {
    std::uint64_t size = 0;
    raw(&size, sizeof(size));
    if (size > left_) {  // no element takes less than a byte: do not allocate for broken counts
      is_sound_ = false;
      size = 0;
    }
    container.resize(static_cast<std::size_t>(size));
    return container.size();
  }
  bool isSound() const { return is_sound_ && left_ == 0; }

 private:
  const char* next_;
  std::size_t left_;
  bool is_sound_ = true;
};

template <class Archive, class T>
void number(Archive& archive, T& value) {
  static_assert(std::is_arithmetic_v<std::remove_const_t<T>> || std::is_enum_v<std::remove_const_t<T>>);
  archive.raw(&value, sizeof(value));
}

template <class Archive, class T>
void matrix(Archive& archive, T& value) {
  archive.raw(value.data(), static_cast<std::size_t>(value.size()) * sizeof(*value.data()));
}

template <class Archive>
void text(Archive& archive, typename Archive::template Ref<std::string> value) {
  if (archive.count(value) > 0) archive.raw(&value[0], value.size());
}

template <class Archive, class T>
void numbers(Archive& archive, T& values) {
  if (archive.count(values) > 0) archive.raw(values.data(), values.size() * sizeof(values[0]));
}

/// Fixed-size vectors in one piece.
template <class Archive, class T>
void matrices(Archive& archive, T& values) {
  using Element = typename T::value_type;
  static_assert(sizeof(Element) == sizeof(typename Element::Scalar) * Element::SizeAtCompileTime);
  if (archive.count(values) > 0) archive.raw(values[0].data(), values.size() * sizeof(Element));
}

template <class Archive, class T, class Each>
void list(Archive& archive, T& values, Each each) {
  archive.count(values);
  for (auto& value : values) each(archive, value);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Texture> texture) {
  text(archive, texture.name);
  number(archive, texture.width_px);
  number(archive, texture.height_px);
  numbers(archive, texture.rgb);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Material> material) {
  text(archive, material.name);
  matrix(archive, material.albedo);
  matrix(archive, material.emission);
  number(archive, material.texture);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Mesh> mesh) {
  matrices(archive, mesh.vertices);
  matrices(archive, mesh.normals);
  matrices(archive, mesh.uvs);
  matrices(archive, mesh.triangles);
  numbers(archive, mesh.triangle_material);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Visual> visual) {
  number(archive, visual.mesh);
  matrix(archive, visual.model_from_visual.matrix());
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Collision> collision) {
  number(archive, collision.kind);
  matrix(archive, collision.size_m);
  number(archive, collision.mesh);
  matrix(archive, collision.model_from_collision.matrix());
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Model> model) {
  text(archive, model.name);
  matrix(archive, model.world_from_model.matrix());
  const auto each = [](auto& a, auto& value) { exchange(a, value); };
  list(archive, model.visuals, each);
  list(archive, model.collisions, each);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Light> light) {
  text(archive, light.name);
  number(archive, light.kind);
  matrix(archive, light.color);
  matrix(archive, light.position_m);
  matrix(archive, light.direction);
  number(archive, light.range_m);
  number(archive, light.attenuation_constant);
  number(archive, light.attenuation_linear);
  number(archive, light.attenuation_quadratic);
  number(archive, light.spot_inner_rad);
  number(archive, light.spot_outer_rad);
  number(archive, light.casts_shadows);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Waypoint> waypoint) {
  number(archive, waypoint.time_s);
  number(archive, waypoint.world_from_person.x_m);
  number(archive, waypoint.world_from_person.y_m);
  number(archive, waypoint.world_from_person.yaw_rad);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Person> person) {
  text(archive, person.name);
  number(archive, person.posture);
  number(archive, person.appearance);
  list(archive, person.waypoints, [](auto& a, auto& waypoint) { exchange(a, waypoint); });
  number(archive, person.start_delay_s);
  number(archive, person.loop);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<Scene> scene) {
  const auto each = [](auto& a, auto& value) { exchange(a, value); };
  text(archive, scene.name);
  list(archive, scene.textures, each);
  list(archive, scene.materials, each);
  list(archive, scene.meshes, each);
  list(archive, scene.models, each);
  list(archive, scene.lights, each);
  list(archive, scene.people, each);
  matrix(archive, scene.ambient);
  matrix(archive, scene.background);
}

template <class Archive>
void exchange(Archive& archive, typename Archive::template Ref<LoadedWorld> world) {
  const auto each_text = [](auto& a, auto& value) { text(a, value); };
  exchange(archive, world.scene);
  list(archive, world.warnings, each_text);
  list(archive, world.files, each_text);
  number(archive, world.is_complete);
}

}  // namespace

std::string toBytes(const LoadedWorld& world) {
  Writer writer;
  exchange(writer, world);
  return writer.take();
}

std::optional<LoadedWorld> fromBytes(const std::string& bytes) {
  Reader reader(bytes);
  LoadedWorld world;
  exchange(reader, world);
  if (!reader.isSound()) return std::nullopt;
  return world;
}

}  // namespace frugal_nav::sim
