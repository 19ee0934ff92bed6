#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// What a metric depth was told by.
enum class Cue { kVo, kFloor, kGoal };

/// A place of the image where relative inverse depth and metric depth are both known.
struct MetricSample {
  double z = 0.0;                 ///< relative inverse depth
  double inverse_depth_pm = 0.0;  ///< 1 / depth [1/m]
  double sigma_pm = 0.0;          ///< standard deviation of the latter [1/m], without the network's own
  Cue cue = Cue::kVo;
};

/// How a and b of 1 / depth = a z + b are found.
struct MetricFitParams {
  double network_sigma = 0.12;
  double network_floor_pm = 0.02;
  double huber = 1.5;
  int hypotheses = 60;
  int min_samples = 8;
  double min_inlier_share = 0.4;
  double effective_samples = 25.0;
  double shift_share = 0.2;
  double max_residual = 0.15;
  double process_share = 0.1;
  double process_shift_pm = 0.03;
  double jump_sigma = 4.0;
  int jumps_to_reset = 3;
  double max_age_s = 2.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("network_sigma", network_sigma,
          Field{"", "local error of the network's inverse depth, as a share of it", 0.001, 1.0});
    visit("network_floor_pm", network_floor_pm, Field{"1/m", "the same for what is far", 0.0, 1.0});
    visit("huber", huber, Field{"", "residuals beyond this many sigma count linearly", 0.5, 10.0});
    visit("hypotheses", hypotheses, Field{"", "pairs of samples drawn for a first guess (RANSAC)", 1, 10000});
    visit("min_samples", min_samples, Field{"", "samples needed for a fit", 2, 10000});
    visit("min_inlier_share", min_inlier_share,
          Field{"", "share of the samples' weight that must agree with a fit", 0.05, 1.0});
    visit("effective_samples", effective_samples,
          Field{"", "most samples that one cue counts as: neighbours share the network's error", 1.0, 1e6});
    visit("shift_share", shift_share,
          Field{"",
                "how large the shift b is thought to be before anything is seen, as a share of the median "
                "inverse depth: it decides where all samples are equally far",
                0.001, 100.0});
    visit("max_residual", max_residual,
          Field{"", "a fit whose samples are off by more (median) is none: an upright thing taken for floor",
                0.01, 1.0});
    visit("process_share", process_share,
          Field{"1/sqrt(s)", "how fast the scale a wanders between images, as a share of it", 0.0, 10.0});
    visit("process_shift_pm", process_shift_pm,
          Field{"1/m/sqrt(s)", "how fast the shift b wanders", 0.0, 10.0});
    visit("jump_sigma", jump_sigma, Field{"", "a fit farther off than this is a jump", 1.0, 100.0});
    visit("jumps_to_reset", jumps_to_reset,
          Field{"", "jumps in a row that are believed; fewer are left out", 1, 100});
    visit("max_age_s", max_age_s,
          Field{"s", "a fit that nothing has renewed is forgotten: by then it errs by 14 %", 0.1, 3600.0});
  }
};

/// 1 / depth = a z + b, with what it rests on.
struct MetricFit {
  bool known = false;
  double a = 0.0;
  double b = 0.0;                                        ///< [1/m]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (a, b)
  int vo_points = 0;                                     ///< samples that agreed, by cue, in the last image
  int floor_points = 0;
  int goal_points = 0;
  double residual = 0.0;  ///< median relative residual of those

  /// 1 / depth of a relative inverse depth [1/m].
  double inverseDepth(double z) const { return a * z + b; }
  /// Its standard deviation by the covariance of a and b [1/m].
  double inverseDepthSigma(double z) const;
};

/// Robust weighted fit to the samples of one image; nothing when they are too few or disagree. `guess` is
/// tried beside the drawn hypotheses.
std::optional<MetricFit> fitMetric(const std::vector<MetricSample>& samples, const MetricFitParams& params,
                                   const std::optional<MetricFit>& guess, Random& random);

/// Follows a and b over images: a Kalman filter whose state wanders; a jump is believed when it lasts.
class MetricFilter {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit MetricFilter(const MetricFitParams& params);

  /// Takes the samples of one image and gives the present fit. Stamps must not go back: reset() first.
  const MetricFit& update(Stamp stamp, const std::vector<MetricSample>& samples);
  const MetricFit& fit() const { return fit_; }
  void reset();

 private:
  void predict(Stamp stamp);
  void correct(const MetricFit& measured);

  MetricFitParams params_;
  Random random_{1, "metric fit"};
  MetricFit fit_;
  Stamp stamp_{};
  Stamp renewed_{};
  int jumps_ = 0;
};

}  // namespace frugal_nav
