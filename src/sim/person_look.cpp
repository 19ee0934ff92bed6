#include "person_look.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <frugal_nav/common/random.hpp>

namespace frugal_nav::sim {
namespace {

template <std::size_t N>
Eigen::Vector3f pick(Random& random, const std::array<std::array<float, 3>, N>& colors, double spread) {
  const auto& c = colors[static_cast<std::size_t>(random.integer(0, static_cast<int>(N) - 1))];
  Eigen::Vector3f color(c[0], c[1], c[2]);
  for (int i = 0; i < 3; ++i) color[i] += static_cast<float>(random.uniform(-spread, spread));
  return color.cwiseMax(0.02F).cwiseMin(0.97F);
}

constexpr std::array<std::array<float, 3>, 7> kSkins{{{0.96F, 0.82F, 0.73F},
                                                      {0.92F, 0.75F, 0.63F},
                                                      {0.87F, 0.68F, 0.53F},
                                                      {0.78F, 0.58F, 0.43F},
                                                      {0.66F, 0.46F, 0.33F},
                                                      {0.50F, 0.34F, 0.25F},
                                                      {0.37F, 0.25F, 0.19F}}};
constexpr std::array<std::array<float, 3>, 4> kDarkHair{
    {{0.07F, 0.06F, 0.06F}, {0.12F, 0.09F, 0.07F}, {0.20F, 0.13F, 0.09F}, {0.45F, 0.44F, 0.43F}}};
constexpr std::array<std::array<float, 3>, 7> kAnyHair{{{0.08F, 0.07F, 0.06F},
                                                        {0.20F, 0.13F, 0.08F},
                                                        {0.33F, 0.21F, 0.12F},
                                                        {0.55F, 0.40F, 0.22F},
                                                        {0.74F, 0.60F, 0.36F},
                                                        {0.48F, 0.20F, 0.10F},
                                                        {0.66F, 0.65F, 0.63F}}};
constexpr std::array<std::array<float, 3>, 4> kIrises{
    {{0.28F, 0.17F, 0.09F}, {0.20F, 0.13F, 0.09F}, {0.33F, 0.46F, 0.56F}, {0.36F, 0.42F, 0.25F}}};
constexpr std::array<std::array<float, 3>, 9> kShirts{{{0.86F, 0.87F, 0.88F},
                                                       {0.16F, 0.24F, 0.42F},
                                                       {0.55F, 0.13F, 0.14F},
                                                       {0.18F, 0.38F, 0.28F},
                                                       {0.80F, 0.62F, 0.20F},
                                                       {0.24F, 0.25F, 0.27F},
                                                       {0.44F, 0.60F, 0.75F},
                                                       {0.52F, 0.32F, 0.52F},
                                                       {0.84F, 0.42F, 0.26F}}};
constexpr std::array<std::array<float, 3>, 6> kTrousers{{{0.15F, 0.20F, 0.33F},
                                                         {0.24F, 0.31F, 0.43F},
                                                         {0.13F, 0.13F, 0.14F},
                                                         {0.45F, 0.39F, 0.30F},
                                                         {0.33F, 0.34F, 0.35F},
                                                         {0.27F, 0.23F, 0.18F}}};
constexpr std::array<std::array<float, 3>, 5> kShoes{{{0.09F, 0.08F, 0.08F},
                                                      {0.30F, 0.18F, 0.10F},
                                                      {0.85F, 0.85F, 0.84F},
                                                      {0.55F, 0.13F, 0.12F},
                                                      {0.20F, 0.25F, 0.35F}}};

HairStyle drawHair(Random& random, bool broad) {
  const double draw = random.uniform(0.0, 1.0);
  if (broad) {
    if (draw < 0.12) return HairStyle::kBald;
    if (draw < 0.60) return HairStyle::kShort;
    if (draw < 0.82) return HairStyle::kFull;
    return draw < 0.92 ? HairStyle::kCurly : HairStyle::kLong;
  }
  if (draw < 0.12) return HairStyle::kShort;
  if (draw < 0.30) return HairStyle::kFull;
  if (draw < 0.42) return HairStyle::kCurly;
  return draw < 0.76 ? HairStyle::kLong : HairStyle::kBun;
}

}  // namespace

PersonLook drawLook(std::uint64_t appearance) {
  Random random(appearance, "person look");
  PersonLook look;
  look.broad_shoulders = random.chance(0.5);
  look.height_m = look.broad_shoulders ? std::clamp(1.77 + random.normal(0.07), 1.60, 1.95)
                                       : std::clamp(1.65 + random.normal(0.065), 1.50, 1.82);
  look.girth = std::clamp(1.0 + random.normal(0.08), 0.86, 1.22);
  look.skin = pick(random, kSkins, 0.015);
  const bool dark = look.skin.x() < 0.72F;
  look.hair = dark ? pick(random, kDarkHair, 0.015) : pick(random, kAnyHair, 0.02);
  look.iris = pick(random, kIrises, 0.03);
  if (dark) look.iris = Eigen::Vector3f(0.17F, 0.11F, 0.08F);
  const float rouge = static_cast<float>(look.broad_shoulders ? 0.35 : random.uniform(0.45, 0.8));
  look.lips = look.skin * (1.0F - rouge) + Eigen::Vector3f(0.62F, 0.22F, 0.22F) * rouge;
  look.shirt = pick(random, kShirts, 0.04);
  look.shirt_second = pick(random, kShirts, 0.04);
  if ((look.shirt - look.shirt_second).norm() < 0.3F)
    look.shirt_second = Eigen::Vector3f(0.92F, 0.92F, 0.90F);
  look.trousers = pick(random, kTrousers, 0.03);
  look.shoes = pick(random, kShoes, 0.02);
  look.hair_style = drawHair(random, look.broad_shoulders);
  look.pattern = static_cast<ShirtPattern>(random.integer(0, 4));
  if (look.broad_shoulders && random.chance(0.45)) look.beard = random.chance(0.5) ? 0.35 : 0.85;
  look.glasses = random.chance(0.3);
  look.long_sleeves = look.pattern == ShirtPattern::kOpenJacket || random.chance(0.55);
  look.shorts = random.chance(0.12);
  look.grain = appearance;
  return look;
}

double jawWidth(double height_share) {
  constexpr double kJawBegins = -0.15;
  if (height_share > kJawBegins) return 1.0;
  const double down = (kJawBegins - height_share) / (1.0 + kJawBegins);
  return 1.0 - 0.20 * down * std::sqrt(down);
}

double hairline(HairStyle style, double longitude) {
  const bool is_long = style == HairStyle::kLong;
  // Forehead, temple, sideburn, above the ear, behind it, nape.
  const std::array<double, 8> from_face{0.0, 0.70, 1.10, 1.40, 1.60, 1.85, 2.10, M_PI};
  const std::array<double, 8> bare{0.74, 0.66, 0.40, -0.08, 0.22, 0.16, -0.45, -0.60};
  const std::array<double, 8> covered{0.80, 0.66, 0.05, -1.70, -1.90, -1.90, -1.90, -1.90};
  const std::array<double, 8>& line = is_long ? covered : bare;
  const double angle = std::abs(longitude);
  std::size_t i = 1;
  while (i + 1 < from_face.size() && from_face[i] < angle) ++i;
  const double share = (angle - from_face[i - 1]) / (from_face[i] - from_face[i - 1]);
  return line[i - 1] + share * (line[i] - line[i - 1]);
}

}  // namespace frugal_nav::sim
