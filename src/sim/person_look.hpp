#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

enum class HairStyle { kBald, kShort, kFull, kCurly, kLong, kBun };
enum class ShirtPattern { kPlain, kStripes, kChecks, kPrint, kOpenJacket };

/// How one person looks: everything that its body and its textures are made from. Colours are sRGB in [0, 1].
struct PersonLook {
  double height_m = 1.75;
  double girth = 1.0;  ///< of trunk and limbs, 1 for a common build
  bool broad_shoulders = true;
  Eigen::Vector3f skin, hair, iris, lips, shirt, shirt_second, trousers, shoes;
  HairStyle hair_style = HairStyle::kShort;
  ShirtPattern pattern = ShirtPattern::kPlain;
  double beard = 0.0;  ///< 0 none, 0.35 stubble, 0.9 full
  bool glasses = false;
  bool long_sleeves = true;
  bool shorts = false;
  std::uint64_t grain = 0;  ///< seed of the fine noise in the textures
};

/// Draws a look; the same `appearance` gives the same one.
PersonLook drawLook(std::uint64_t appearance);

/// Skin, eyes, brows, nose shading, mouth and beard on the sphere of the head: columns over 360 degrees with
/// the face in the middle, rows from the crown down to the chin.
Texture paintHead(const PersonLook& look);

/// The shirt as wrapped around trunk and arms: the breast in the middle.
Texture paintShirt(const PersonLook& look);

/// Woven cloth of a colour.
Texture paintCloth(const Eigen::Vector3f& color, std::uint64_t grain);

/// Strands of hair of a colour.
Texture paintHair(const Eigen::Vector3f& color, std::uint64_t grain);

/// Half axes of the head of a person 1.75 m tall [m]: depth, width, height.
inline const Eigen::Vector3d kHeadRadii_m{0.098, 0.077, 0.118};

/// Width of the head at a share -1 (chin) .. 1 (crown) of its half height, relative to an ellipsoid's.
double jawWidth(double height_share);

/// Latitude on the head above which hair grows, by longitude from the face [rad].
double hairline(HairStyle style, double longitude);

}  // namespace frugal_nav::sim
