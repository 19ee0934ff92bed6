#include "surfaces.hpp"

#include <algorithm>
#include <cmath>

#include <embree3/rtcore_ray.h>

namespace frugal_nav::sim {
namespace {

constexpr float kMinCos = 0.05F;

std::uint32_t packTexel(std::uint32_t r, std::uint32_t g, std::uint32_t b) { return r | g << 8U | b << 16U; }

std::uint32_t toByte(float srgb) {
  return static_cast<std::uint32_t>(std::lround(255.0F * std::clamp(srgb, 0.0F, 1.0F)));
}

/// Half the binary logarithm of the texture-coordinate area over the surface's area.
float log2UvPerMetre(const Mesh& mesh, const Eigen::Vector3i& triangle) {
  const auto vertex = [&](int i) { return mesh.vertices[static_cast<std::size_t>(triangle[i])]; };
  const auto uv = [&](int i) { return mesh.uvs[static_cast<std::size_t>(triangle[i])]; };
  const float area = (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0)).norm();
  const Eigen::Vector2f a = uv(1) - uv(0);
  const Eigen::Vector2f b = uv(2) - uv(0);
  const float uv_area = std::abs(a.x() * b.y() - a.y() * b.x());
  if (area <= 0.0F || uv_area <= 0.0F) return -20.0F;  // one colour for the whole triangle: any level will do
  return 0.5F * std::log2(uv_area / area);
}

}  // namespace

float linearFromSrgb(float srgb) {
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

float srgbFromLinear(float linear) {
  return linear <= 0.0031308F ? linear * 12.92F : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
}

Surfaces::Surfaces(const Scene& scene) : scene_(scene) {
  for (std::size_t i = 0; i < linear_.size(); ++i)
    linear_[i] = linearFromSrgb(static_cast<float>(i) / 255.0F);
  for (const Material& material : scene.materials) {
    paints_.push_back({material.albedo.unaryExpr(&linearFromSrgb),
                       material.emission.unaryExpr(&linearFromSrgb), material.texture});
  }
  paints_.push_back({Eigen::Vector3f::Constant(linearFromSrgb(0.7F)), Eigen::Vector3f::Zero(), -1});
  for (const Texture& texture : scene.textures) textures_.push_back(pyramid(texture));
  for (const Mesh& mesh : scene.meshes) {
    std::vector<float> densities;
    if (mesh.uvs.size() == mesh.vertices.size()) {
      for (const Eigen::Vector3i& triangle : mesh.triangles) {
        densities.push_back(log2UvPerMetre(mesh, triangle));
      }
    }
    log2_uv_per_m_.push_back(std::move(densities));
  }
}

std::vector<Surfaces::Level> Surfaces::pyramid(const Texture& texture) const {
  Level base{texture.width_px, texture.height_px, {}};
  for (std::size_t i = 0; i + 2 < texture.rgb.size(); i += 3) {
    base.rgbx.push_back(packTexel(texture.rgb[i], texture.rgb[i + 1], texture.rgb[i + 2]));
  }
  std::vector<Level> levels{std::move(base)};
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Level& fine = levels.back();
    Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (const int dy : {0, 1}) {
          for (const int dx : {0, 1}) {
            const int row = std::min(2 * y + dy, fine.height - 1);
            const int column = std::min(2 * x + dx, fine.width - 1);
            sum += linearTexel(fine.rgbx[static_cast<std::size_t>(row * fine.width + column)]);
          }
        }
        const Eigen::Vector3f srgb = (0.25F * sum).unaryExpr(&srgbFromLinear);
        coarse.rgbx.push_back(packTexel(toByte(srgb.x()), toByte(srgb.y()), toByte(srgb.z())));
      }
    }
    levels.push_back(std::move(coarse));
  }
  return levels;
}

SurfacePoint Surfaces::at(const SurfaceHit& hit, const RTCRayHit8& rays, int lane, float footprint_m) const {
  const Mesh& mesh = scene_.meshes[static_cast<std::size_t>(hit.mesh)];
  const auto triangle_index = static_cast<std::size_t>(hit.triangle);
  const Eigen::Vector3i& triangle = mesh.triangles[triangle_index];
  const auto a = static_cast<std::size_t>(triangle[0]);
  const auto b = static_cast<std::size_t>(triangle[1]);
  const auto c = static_cast<std::size_t>(triangle[2]);
  const float u = rays.hit.u[lane];
  const float v = rays.hit.v[lane];
  const float w = 1.0F - u - v;
  const Eigen::Vector3f direction(rays.ray.dir_x[lane], rays.ray.dir_y[lane], rays.ray.dir_z[lane]);
  const Eigen::Vector3f hit_normal(rays.hit.Ng_x[lane], rays.hit.Ng_y[lane], rays.hit.Ng_z[lane]);

  SurfacePoint point;
  point.face_normal =
      *hit.world_from_hit_normal * (hit_normal * (1.0F / std::max(1e-20F, hit_normal.norm())));
  float facing = point.face_normal.dot(direction);
  if (facing > 0.0F) {
    point.face_normal = -point.face_normal;
    facing = -facing;
  }
  point.normal_world = point.face_normal;
  if (!mesh.normals.empty()) {
    const Eigen::Vector3f normal =
        *hit.world_from_mesh_rotation * (w * mesh.normals[a] + u * mesh.normals[b] + v * mesh.normals[c]);
    const float squared = normal.squaredNorm();
    if (squared > 1e-6F) {
      const float side = normal.dot(point.face_normal) < 0.0F ? -1.0F : 1.0F;
      point.normal_world = normal * (side / std::sqrt(squared));
    }
  }

  const int material =
      triangle_index < mesh.triangle_material.size() ? mesh.triangle_material[triangle_index] : -1;
  const Paint& paint = material >= 0 ? paints_[static_cast<std::size_t>(material)] : paints_.back();
  point.albedo = paint.albedo;
  point.emission = paint.emission;
  const std::vector<float>& densities = log2_uv_per_m_[static_cast<std::size_t>(hit.mesh)];
  if (paint.texture >= 0 && !densities.empty()) {
    const std::vector<Level>& levels = textures_[static_cast<std::size_t>(paint.texture)];
    const Eigen::Vector2f uv = w * mesh.uvs[a] + u * mesh.uvs[b] + v * mesh.uvs[c];
    // A pixel is longer along the slope than across by 1 / cos: the level fits the geometric mean.
    const float length = direction.norm();
    const float stretch = length / std::max(kMinCos * length, -facing);
    const float texels = footprint_m * static_cast<float>(std::max(levels[0].width, levels[0].height));
    const float lod =
        densities[triangle_index] + 0.5F * std::log2(std::max(1e-12F, texels * texels * stretch));
    point.albedo = point.albedo.cwiseProduct(sampleTexture(levels, uv, lod));
  }
  return point;
}

Eigen::Vector3f Surfaces::sampleTexture(const std::vector<Level>& levels, const Eigen::Vector2f& uv,
                                        float lod) const {
  const float u = uv.x() - std::floor(uv.x());
  const float v = uv.y() - std::floor(uv.y());
  const auto last = static_cast<float>(levels.size() - 1);
  const float level = std::clamp(lod, 0.0F, last);
  const auto fine = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(fine);
  const Eigen::Vector3f near = sampleLevel(levels[fine], u, v);
  if (blend < 0.02F || fine + 1 >= levels.size()) return near;
  return near + blend * (sampleLevel(levels[fine + 1], u, v) - near);
}

Eigen::Vector3f Surfaces::sampleLevel(const Level& level, float u, float v) const {
  const float x = u * static_cast<float>(level.width) - 0.5F + static_cast<float>(level.width);
  const float y = (1.0F - v) * static_cast<float>(level.height) - 0.5F + static_cast<float>(level.height);
  const int column = static_cast<int>(x);  // in [0, 2 * width): the texture repeats
  const int row = static_cast<int>(y);
  const float fx = x - static_cast<float>(column);
  const float fy = y - static_cast<float>(row);
  const int x0 = column >= level.width ? column - level.width : column;
  const int y0 = row >= level.height ? row - level.height : row;
  const int x1 = x0 + 1 == level.width ? 0 : x0 + 1;
  const int y1 = y0 + 1 == level.height ? 0 : y0 + 1;
  const auto texel = [&](int tx, int ty) {
    return linearTexel(level.rgbx[static_cast<std::size_t>(ty * level.width + tx)]);
  };
  const Eigen::Vector3f top = (1.0F - fx) * texel(x0, y0) + fx * texel(x1, y0);
  const Eigen::Vector3f bottom = (1.0F - fx) * texel(x0, y1) + fx * texel(x1, y1);
  return (1.0F - fy) * top + fy * bottom;
}

}  // namespace frugal_nav::sim
