#include "motion_smear.hpp"

#include <algorithm>
#include <cmath>

namespace frugal_nav::sim {
namespace {

constexpr float kFar_m = 1e3F;     // where the background is taken to be
constexpr float kStill_px = 0.3F;  // a shorter smear changes nothing that can be seen
constexpr int kMaxTaps = 8;
constexpr int kRowsATask = 16;

/// The motion of the image between two neighbouring instants.
class Motion {
 public:
  Motion(const Lens& lens, const std::vector<Eigen::Isometry3d>& poses)
      : focal_px_(lens.focal_px()), intervals_(static_cast<float>(poses.size() - 1)) {
    const Eigen::Isometry3d& middle = poses[poses.size() / 2];
    first_from_middle_ = (poses.front().inverse() * middle).matrix().cast<float>();
    last_from_middle_ = (poses.back().inverse() * middle).matrix().cast<float>();
  }

  /// How far a point moves [px]; distortion is left out, it changes the motion by a few percent.
  Eigen::Vector2f of(float ray_x, float ray_y, float depth_m) const {
    const float z = std::min(depth_m, kFar_m);
    const Eigen::Vector4f p(ray_x * z, ray_y * z, z, 1.0F);
    const Eigen::Vector4f first = first_from_middle_ * p;
    const Eigen::Vector4f last = last_from_middle_ * p;
    if (first.z() <= 0.0F || last.z() <= 0.0F) return Eigen::Vector2f::Zero();
    return (focal_px_ / intervals_) * (last.head<2>() / last.z() - first.head<2>() / first.z());
  }

 private:
  float focal_px_;
  float intervals_;
  Eigen::Matrix4f first_from_middle_;
  Eigen::Matrix4f last_from_middle_;
};

/// Light between the pixels, by bilinear interpolation; the image's border is continued.
Eigen::Vector3f lightAt(const LightImage& image, int width, int height, float x, float y) {
  const float inside_x = std::clamp(x, 0.0F, static_cast<float>(width - 1));
  const float inside_y = std::clamp(y, 0.0F, static_cast<float>(height - 1));
  const int x0 = std::min(static_cast<int>(inside_x), width - 2);
  const int y0 = std::min(static_cast<int>(inside_y), height - 2);
  const float fx = inside_x - static_cast<float>(x0);
  const float fy = inside_y - static_cast<float>(y0);
  const Eigen::Vector3f* upper =
      &image.light_lx[static_cast<std::size_t>(y0) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x0)];
  const Eigen::Vector3f* lower = upper + width;
  return (1.0F - fy) * ((1.0F - fx) * upper[0] + fx * upper[1]) +
         fy * ((1.0F - fx) * lower[0] + fx * lower[1]);
}

}  // namespace

void smearAlongMotion(const Lens& lens, const std::vector<Eigen::Isometry3d>& world_from_optical,
                      WorkerPool& pool, LightImage& image) {
  if (world_from_optical.size() < 2) return;
  const Motion motion(lens, world_from_optical);
  const int width = lens.width();
  const int height = lens.height();
  image.smeared_lx.resize(image.light_lx.size());
  pool.run((height + kRowsATask - 1) / kRowsATask, [&](int task) {
    const int last = std::min(height, (task + 1) * kRowsATask);
    for (int row = task * kRowsATask; row < last; ++row) {
      for (int column = 0; column < width; ++column) {
        const auto pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(column);
        const Eigen::Vector2f shift =
            motion.of(lens.rayX(column, row), lens.rayY(column, row), image.depth_m[pixel]);
        const float length = shift.norm();
        if (length < kStill_px) {
          image.smeared_lx[pixel] = image.light_lx[pixel];
          continue;
        }
        const int taps = std::min(kMaxTaps, 1 + static_cast<int>(length));
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int tap = 0; tap < taps; ++tap) {
          const float along = (static_cast<float>(tap) + 0.5F) / static_cast<float>(taps) - 0.5F;
          sum += lightAt(image, width, height, static_cast<float>(column) + along * shift.x(),
                         static_cast<float>(row) + along * shift.y());
        }
        image.smeared_lx[pixel] = sum * (1.0F / static_cast<float>(taps));
      }
    }
  });
  image.light_lx.swap(image.smeared_lx);
}

}  // namespace frugal_nav::sim
