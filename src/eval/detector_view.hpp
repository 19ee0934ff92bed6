#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/training_scene.hpp>
#include <frugal_nav/eval/view_truth.hpp>
#include <frugal_nav/perception/detection.hpp>
#include <frugal_nav/sim/camera.hpp>
#include <frugal_nav/sim/lighting.hpp>

namespace frugal_nav::eval {

/// The robot's camera before a head that is 2 to 6 m away: frame after frame of one view, each with its own
/// noise and a little sway of the robot.
class DetectorView {
 public:
  struct Frame {
    cv::Mat bgr;
    std::vector<PersonBox> truth;  ///< heads, or whole persons
  };

  /// Nothing when no such place is found in the scene. What is given must outlive the view.
  static std::optional<DetectorView> draw(const TrainingScene& place, const sim::RayTracer& tracer,
                                          const Eigen::Isometry3d& base_from_optical, int width_px,
                                          bool heads, std::uint64_t seed, int number);

  /// The first frame is taken from the pose that was drawn.
  Frame next();
  Pinhole pinhole() const;
  const std::string& light() const { return light_; }

 private:
  DetectorView(const TrainingScene& place, const sim::RayTracer& tracer, const Eigen::Isometry3d& pose,
               const sim::CameraParams& camera, const std::string& light, bool heads, std::uint64_t seed,
               const Random& random);

  const TrainingScene& place_;
  const sim::RayTracer& tracer_;
  Eigen::Isometry3d world_from_optical_;
  std::string light_;
  bool heads_;
  sim::Lighting lighting_;
  sim::Camera camera_;
  Random random_;
  bool is_first_ = true;
};

/// For each detection the index of the truth it found (most overlap, at least half of the union; the best
/// scores choose first, each truth once), or -1. Detections must be in the order of their scores.
std::vector<int> matchBoxes(const std::vector<Detection>& detections, const std::vector<PersonBox>& truth);

/// Overlap of two boxes over their union.
double boxOverlap(const cv::Rect2d& a, const cv::Rect2d& b);

/// A detection after matching: its score, and whether it found something.
struct JudgedDetection {
  double score = 0.0;
  bool is_hit = false;
};

/// Area under the precision-recall curve, precision made monotonous (PASCAL VOC 2010). `targets` is how many
/// things there were to find; nullopt of none.
std::optional<double> averagePrecision(std::vector<JudgedDetection> detections, int targets);

}  // namespace frugal_nav::eval
