#include "random_paint.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/mesh_file.hpp>

namespace frugal_nav::eval {
namespace {

constexpr int kLargestTexture_px = 512;
constexpr int kComputed_px = 256;

Eigen::Vector3f drawColour(Random& random) {
  // Mostly greyish, as rooms are; some strong.
  const auto lightness = static_cast<float>(random.uniform(0.08, 0.95));
  const double saturation = random.chance(0.7) ? 0.12 : 0.45;
  Eigen::Vector3f colour;
  for (int i = 0; i < 3; ++i)
    colour[i] = std::clamp(lightness + static_cast<float>(random.normal(saturation)), 0.02F, 1.0F);
  return colour;
}

void shrink(sim::Texture& texture) {
  const int longest = std::max(texture.width_px, texture.height_px);
  if (longest <= kLargestTexture_px) return;
  const cv::Mat image(texture.height_px, texture.width_px, CV_8UC3, texture.rgb.data());
  const double scale = static_cast<double>(kLargestTexture_px) / longest;
  cv::Mat small;
  cv::resize(image, small, cv::Size(), scale, scale, cv::INTER_AREA);
  texture.width_px = small.cols;
  texture.height_px = small.rows;
  texture.rgb.assign(small.datastart, small.dataend);
}

/// Smooth noise in [0, 1] that repeats at the edges: octaves of random grids, each finer and weaker.
cv::Mat cloudNoise(int coarsest_cells, int octaves, Random& random) {
  cv::Mat sum = cv::Mat::zeros(kComputed_px, kComputed_px, CV_32FC1);
  double weight = 1.0;
  int cells = coarsest_cells;
  for (int octave = 0; octave < octaves && cells <= kComputed_px; ++octave) {
    cv::Mat grid(cells, cells, CV_32FC1);
    for (int i = 0; i < cells * cells; ++i)
      grid.ptr<float>()[i] = static_cast<float>(random.uniform(0.0, 1.0));
    cv::Mat padded;
    cv::copyMakeBorder(grid, padded, 2, 2, 2, 2, cv::BORDER_WRAP);
    const int cell_px = kComputed_px / cells;
    cv::Mat large;
    cv::resize(padded, large, padded.size() * cell_px, 0, 0, cv::INTER_CUBIC);
    sum += weight * large(cv::Rect(2 * cell_px, 2 * cell_px, cells * cell_px, cells * cell_px));
    weight *= 0.6;
    cells *= 2;
  }
  cv::normalize(sum, sum, 0.0, 1.0, cv::NORM_MINMAX);
  return sum;
}

/// A pattern in [0, 1] from a function of the position in cells.
cv::Mat pattern(int cells, const std::function<double(double, double)>& value) {
  cv::Mat image(kComputed_px, kComputed_px, CV_32FC1);
  const double step = static_cast<double>(cells) / kComputed_px;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column)
      image.at<float>(row, column) = static_cast<float>(value(column * step, row * step));
  }
  return image;
}

cv::Mat drawPattern(Random& random) {
  const int cells = 1 << random.integer(1, 4);  // a power of two, so that the picture repeats
  const auto fraction = [](double x) { return x - std::floor(x); };
  switch (random.integer(0, 5)) {
    case 0:
      return cloudNoise(2 << random.integer(0, 2), 5, random);
    case 1:  // speckles, carpet
      return cloudNoise(64 << random.integer(0, 2), 2, random);
    case 2: {  // tiles with joints
      const double joint = random.uniform(0.02, 0.08);
      return pattern(
          cells, [=](double x, double y) { return fraction(x) < joint || fraction(y) < joint ? 1.0 : 0.0; });
    }
    case 3:  // stripes
      return pattern(cells, [=](double x, double) { return fraction(x) < 0.5 ? 1.0 : 0.0; });
    case 4:  // checks
      return pattern(cells, [](double x, double y) {
        return (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y))) % 2 == 0 ? 1.0 : 0.0;
      });
    default: {  // boards, each of its own shade
      std::vector<double> shades;
      for (int i = 0; i < cells; ++i) shades.push_back(random.uniform(0.0, 1.0));
      return pattern(cells, [=](double x, double) {
        return fraction(x) < 0.03 ? 0.0 : shades[static_cast<std::size_t>(x)];
      });
    }
  }
}

/// Two colours mixed by a pattern, over fine noise.
sim::Texture computeTexture(Random& random) {
  const cv::Mat mix = drawPattern(random);
  const cv::Mat grain = cloudNoise(32, 3, random);
  const Eigen::Vector3f a = drawColour(random);
  const bool faint = random.chance(0.6);
  const Eigen::Vector3f other = drawColour(random);
  const Eigen::Vector3f b = faint ? Eigen::Vector3f(a + 0.25F * (other - a)) : other;
  const auto grain_strength = static_cast<float>(random.uniform(0.0, 0.2));
  sim::Texture texture{"computed", kComputed_px, kComputed_px, {}};
  for (int i = 0; i < kComputed_px * kComputed_px; ++i) {
    const float share = mix.ptr<float>()[i];
    const float light = grain_strength * (grain.ptr<float>()[i] - 0.5F);
    for (int c = 0; c < 3; ++c) {
      const float value = std::clamp(a[c] + share * (b[c] - a[c]) + light, 0.0F, 1.0F);
      texture.rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0F * value)));
    }
  }
  return texture;
}

}  // namespace

std::vector<sim::Texture> readTextures(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  std::vector<sim::Texture> textures;
  for (const std::string& path : paths) {
    if (auto texture = sim::readTexture(path)) {
      shrink(*texture);
      textures.push_back(std::move(*texture));
    }
  }
  if (textures.empty()) throw ConfigError("no image in '" + folder + "': name the package's folder `worlds`");
  return textures;
}

Paint drawPaint(const std::vector<sim::Texture>& stock, Random& random, sim::Scene& scene) {
  sim::Material material;
  Paint paint;
  const double kind = random.uniform(0.0, 1.0);
  constexpr double kPlain = 0.3;
  constexpr double kPrinted = 0.65;
  if (kind < kPlain) {
    material.albedo = drawColour(random);
  } else {
    const bool printed = kind < kPrinted;
    material.texture = static_cast<int>(scene.textures.size());
    scene.textures.push_back(
        printed ? stock[static_cast<std::size_t>(random.integer(0, static_cast<int>(stock.size()) - 1))]
                : computeTexture(random));
    for (int c = 0; c < 3; ++c) material.albedo[c] = static_cast<float>(random.uniform(0.65, 1.0));
    paint.repeat_m = std::exp(random.uniform(std::log(0.25), std::log(2.5)));
  }
  paint.material = static_cast<int>(scene.materials.size());
  material.name = "paint_" + std::to_string(paint.material);
  scene.materials.push_back(material);
  return paint;
}

void wear(const Paint& paint, const Eigen::Vector2d& face_m, sim::Mesh& mesh) {
  const Eigen::Vector2f repeats = (face_m / paint.repeat_m).cast<float>();
  for (Eigen::Vector2f& uv : mesh.uvs) uv = uv.cwiseProduct(repeats);
  mesh.triangle_material.assign(mesh.triangles.size(), paint.material);
}

}  // namespace frugal_nav::eval
