// The pictures on a person: the face above all. Lengths on the face are millimetres on the head of a person
// 1.75 m tall: y to the face's left, z up from the middle of the head, where the eyes are.
#include "person_look.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/random.hpp>

namespace frugal_nav::sim {
namespace {

using Color = Eigen::Vector3f;

Color mix(const Color& from, const Color& to, double share) {
  return from + (to - from) * static_cast<float>(std::clamp(share, 0.0, 1.0));
}

Color shade(const Color& color, double factor) { return color * static_cast<float>(factor); }

double gauss(double y, double z, double sigma_y, double sigma_z) {
  return std::exp(-0.5 * (y * y / (sigma_y * sigma_y) + z * z / (sigma_z * sigma_z)));
}

/// 1 where `inside` is well positive, 0 where it is negative, over a soft edge of `width`.
double soft(double inside, double width) { return std::clamp(inside / width + 0.5, 0.0, 1.0); }

void setPixel(Texture& texture, int column, int row, const Color& color) {
  const std::size_t at = 3U * (static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width_px) +
                               static_cast<std::size_t>(column));
  for (int i = 0; i < 3; ++i) {
    texture.rgb[at + static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(color[i], 0.0F, 1.0F)));
  }
}

Texture blank(const char* name, int width_px, int height_px) {
  Texture texture{name, width_px, height_px, {}};
  texture.rgb.resize(3U * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  return texture;
}

Color paintEye(const PersonLook& look, double y, double z, Color color) {
  constexpr double kEye_mm = 32.0;
  const double side = std::abs(y) - kEye_mm;
  color = shade(color, 1.0 - 0.16 * gauss(side, z - 4.0, 15.0, 8.0));
  const double t = side / 15.5;
  const double arc = 1.0 - t * t;
  const double upper = 0.5 + 6.2 * arc;
  const double lower = 0.5 - 5.0 * arc;
  if (arc > 0.0) {
    const double open = soft(std::min(upper - z, z - lower), 0.8);
    Color eye(0.93F, 0.92F, 0.90F);
    const double from_iris = std::hypot(side, z - 1.2);
    eye = mix(eye, look.iris, soft(6.6 - from_iris, 0.8));
    eye = mix(eye, Color(0.03F, 0.03F, 0.03F), soft(3.0 - from_iris, 0.8));
    eye = mix(eye, Color(1.0F, 1.0F, 1.0F),
              soft(1.3 - std::hypot(y - (y > 0 ? kEye_mm : -kEye_mm) - 2.0, z - 3.4), 0.8));
    eye = shade(eye, 1.0 - 0.35 * soft(z - upper + 3.0, 3.0));
    color = mix(color, eye, open);
    color = mix(color, shade(look.skin, 0.22), 0.9 * soft(1.3 - std::abs(z - upper), 0.8));
    color = mix(color, shade(look.skin, 0.55), 0.5 * soft(0.8 - std::abs(z - lower), 0.8));
  }
  const double along = (std::abs(y) - 33.0) / 20.0;
  const double brow_z = 19.0 + 4.0 * (1.0 - along * along) - 1.5 * along;
  const double thick = (look.broad_shoulders ? 3.6 : 2.4) * std::sqrt(std::max(0.0, 1.0 - along * along));
  return mix(color, shade(look.hair, 0.75), 0.85 * soft(thick - std::abs(z - brow_z), 1.2));
}

Color paintNose(double y, double z, Color color) {
  const double side = std::abs(y);
  if (z < 12.0 && z > -42.0) {
    const double flank = 9.0 + 6.0 * std::clamp(-z / 36.0, 0.0, 1.0);
    color = shade(color, 1.0 - 0.13 * gauss(side - flank, 0.0, 4.0, 1.0));
    color = shade(color, 1.0 + 0.06 * gauss(side, 0.0, 3.5, 1.0));
  }
  color = shade(color, 1.0 - 0.12 * gauss(side, z + 42.0, 12.0, 2.5));
  return shade(color, 1.0 - 0.6 * gauss(side - 7.0, z + 39.0, 2.8, 1.7));
}

Color paintMouth(const PersonLook& look, double y, double z, Color color) {
  constexpr double kMouth_mm = -62.0;
  const double t = y / 25.0;
  const double arc = 1.0 - t * t;
  if (arc > 0.0) {
    const double bow = 1.0 - 0.35 * gauss(y, 0.0, 4.0, 1.0);
    const double middle = kMouth_mm + 1.5 * t * t;
    const double inside = std::min(middle + 6.5 * arc * bow - z, z - (middle - 8.5 * arc));
    color = mix(color, look.lips, soft(inside, 1.4));
    color = mix(color, shade(look.lips, 0.35), 0.9 * soft(1.1 - std::abs(z - middle), 1.0));
  }
  return shade(color, 1.0 - 0.14 * gauss(y, z - kMouth_mm + 15.0, 16.0, 3.5));
}

Color paintBeard(const PersonLook& look, double y, double z, double noise, Color color) {
  if (look.beard <= 0.0) return color;
  const double cheek_line = -34.0 - 22.0 * (1.0 - std::pow(std::min(1.0, std::abs(y) / 62.0), 2.0));
  const double moustache = std::min(6.0 - std::abs(z + 50.5), 24.0 - std::abs(y));
  const double jaw = cheek_line - z;
  const double lips = 1.0 - std::hypot(y / 22.0, (z + 62.5) / 7.0);
  const double cover = soft(std::max(jaw, moustache), 6.0) * (1.0 - soft(lips, 0.2));
  return mix(color, shade(look.hair, 0.85 + 0.3 * noise), look.beard * cover);
}

Color paintGlasses(double y, double z, Color color) {
  const double rim = std::hypot((std::abs(y) - 32.0) / 23.0, (z + 1.0) / 17.0);
  const double frame = 0.075 - std::abs(rim - 1.0);
  const double bridge = std::min(1.3 - std::abs(z - 4.0), 10.0 - std::abs(y));
  const double temple = std::min(1.5 - std::abs(z - 5.0), std::abs(y) - 54.0);
  const double inside = std::max({frame * 18.0, bridge, temple});
  return mix(color, Color(0.06F, 0.06F, 0.08F), 0.95 * soft(inside, 0.9));
}

double weave(int column, int row) {
  return ((column + row) % 2 == 0 ? 1.0 : -1.0) * ((row % 4) < 2 ? 1.0 : 0.4);
}

}  // namespace

Texture paintHead(const PersonLook& look) {
  constexpr int kWidth = 512;
  constexpr int kHeight = 256;
  Texture texture = blank("head", kWidth, kHeight);
  Random random(look.grain, "person skin");
  const Eigen::Vector3d radii_mm = 1000.0 * kHeadRadii_m;
  for (int row = 0; row < kHeight; ++row) {
    const double latitude = M_PI * (0.5 - (row + 0.5) / kHeight);
    for (int column = 0; column < kWidth; ++column) {
      const double longitude = 2.0 * M_PI * ((column + 0.5) / kWidth - 0.5);
      const double noise = random.uniform(-1.0, 1.0);
      Color color = shade(look.skin, 1.0 + 0.02 * noise);
      const double z = radii_mm.z() * std::sin(latitude);
      const double y = radii_mm.y() * std::cos(latitude) * jawWidth(std::sin(latitude)) * std::sin(longitude);
      if (std::abs(longitude) < 0.5 * M_PI) {
        color =
            mix(color, Color(0.80F, 0.36F, 0.32F), 0.16 * gauss(std::abs(y) - 42.0, z + 28.0, 15.0, 13.0));
        color = paintBeard(look, y, z, noise, color);
        color = paintNose(y, z, color);
        color = paintMouth(look, y, z, color);
        color = paintEye(look, y, z, color);
        if (look.glasses) color = paintGlasses(y, z, color);
      }
      if (look.hair_style != HairStyle::kBald) {
        const double above = latitude - hairline(look.hair_style, longitude);
        color = mix(color, shade(look.hair, 0.9 + 0.2 * noise), soft(above - 0.05 + 0.05 * noise, 0.08));
      }
      setPixel(texture, column, row, color);
    }
  }
  return texture;
}

Texture paintShirt(const PersonLook& look) {
  constexpr int kSize = 192;
  Texture texture = blank("shirt", kSize, kSize);
  Random random(look.grain, "person shirt");
  const int period = random.integer(14, 26);
  const double print_u = random.uniform(0.035, 0.06);
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const double u = (column + 0.5) / kSize;
      const double v = 1.0 - (row + 0.5) / kSize;
      Color color = look.shirt;
      const bool across = row % period < period / 2;
      const bool along = column % period < period / 2;
      switch (look.pattern) {
        case ShirtPattern::kPlain:
          break;
        case ShirtPattern::kStripes:
          if (across) color = look.shirt_second;
          break;
        case ShirtPattern::kChecks:
          color = mix(look.shirt, look.shirt_second, (across ? 0.45 : 0.0) + (along ? 0.45 : 0.0));
          break;
        case ShirtPattern::kPrint:
          if (std::hypot(u - 0.5, 0.6 * (v - 0.66)) < print_u) color = look.shirt_second;
          break;
        case ShirtPattern::kOpenJacket:
          if (std::abs(u - 0.5) < 0.025 + 0.035 * v) color = look.shirt_second;
          break;
      }
      const bool breast_seam = look.pattern != ShirtPattern::kOpenJacket && std::abs(u - 0.5) < 0.004;
      const double grain = 0.03 * weave(column, row) + 0.03 * random.uniform(-1.0, 1.0);
      setPixel(texture, column, row, shade(color, (breast_seam ? 0.8 : 1.0) + grain));
    }
  }
  return texture;
}

Texture paintCloth(const Eigen::Vector3f& color, std::uint64_t grain) {
  constexpr int kSize = 96;
  Texture texture = blank("cloth", kSize, kSize);
  Random random(grain, "person cloth");
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const double seam = column == 0 || column == kSize / 2 ? -0.15 : 0.0;
      setPixel(texture, column, row,
               shade(color, 1.0 + seam + 0.05 * weave(column, row) + 0.06 * random.uniform(-1.0, 1.0)));
    }
  }
  return texture;
}

Texture paintHair(const Eigen::Vector3f& color, std::uint64_t grain) {
  constexpr int kWidth = 192;
  constexpr int kHeight = 64;
  Texture texture = blank("hair", kWidth, kHeight);
  Random random(grain, "person hair");
  double strand[kWidth];
  for (double& value : strand) value = random.uniform(-1.0, 1.0);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double sheen = 0.25 * std::exp(-std::pow((row - 20.0) / 7.0, 2.0));
      const double light = 1.0 + 0.28 * strand[column] + 0.10 * random.uniform(-1.0, 1.0) + sheen;
      setPixel(texture, column, row, shade(color, light));
    }
  }
  return texture;
}

}  // namespace frugal_nav::sim
