#include "detector_support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include <frugal_nav/perception/metric_fit.hpp>

namespace frugal_nav {
namespace {

constexpr double kOutlier = 3.0;  // sigmas from which a sample does not agree

/// Samples with the weight of their cue: many of one cue share the network's error.
struct Weighted {
  const MetricSample* sample;
  double sigma;
  double weight;  // 1 for an independent sample
};

double residualSigma(const MetricSample& sample, const MetricFitParams& params) {
  return std::hypot(sample.sigma_pm,
                    params.network_sigma * sample.inverse_depth_pm + params.network_floor_pm);
}

std::vector<Weighted> weigh(const std::vector<MetricSample>& samples, const MetricFitParams& params) {
  std::array<int, 3> counts{};
  std::vector<Weighted> weighted;
  for (const MetricSample& sample : samples) {
    if (!std::isfinite(sample.z) || !std::isfinite(sample.inverse_depth_pm) ||
        !(sample.inverse_depth_pm > 0.0))
      continue;
    ++counts[static_cast<std::size_t>(sample.cue)];
    weighted.push_back({&sample, residualSigma(sample, params), 1.0});
  }
  for (Weighted& w : weighted) {
    const int count = counts[static_cast<std::size_t>(w.sample->cue)];
    w.weight = std::min(1.0, params.effective_samples / count);
  }
  return weighted;
}

double residual(const Weighted& w, double a, double b) {
  return (w.sample->inverse_depth_pm - a * w.sample->z - b) / w.sigma;
}

/// Cost of a hypothesis: squares, cut off where a sample disagrees (MSAC).
double costOf(const std::vector<Weighted>& weighted, double a, double b) {
  double cost = 0.0;
  for (const Weighted& w : weighted) {
    const double r = residual(w, a, b);
    cost += w.weight * std::min(r * r, kOutlier * kOutlier);
  }
  return cost;
}

struct Line {
  double a = 0.0;
  double b = 0.0;
  double cost = std::numeric_limits<double>::infinity();
};

void consider(double a, double b, const std::vector<Weighted>& weighted, Line& best) {
  if (!(a > 0.0) || !std::isfinite(a) || !std::isfinite(b)) return;
  const double cost = costOf(weighted, a, b);
  if (cost < best.cost) best = {a, b, cost};
}

Line firstGuess(const std::vector<Weighted>& weighted, const MetricFitParams& params,
                const std::optional<MetricFit>& guess, Random& random) {
  Line best;
  if (guess && guess->known) consider(guess->a, guess->b, weighted, best);
  const int last = static_cast<int>(weighted.size()) - 1;
  for (int i = 0; i < params.hypotheses; ++i) {
    const MetricSample& p = *weighted[static_cast<std::size_t>(random.integer(0, last))].sample;
    const MetricSample& q = *weighted[static_cast<std::size_t>(random.integer(0, last))].sample;
    if (p.z > 0.0) consider(p.inverse_depth_pm / p.z, 0.0, weighted, best);
    if (std::abs(q.z - p.z) < 1e-9) continue;
    const double a = (q.inverse_depth_pm - p.inverse_depth_pm) / (q.z - p.z);
    consider(a, p.inverse_depth_pm - a * p.z, weighted, best);
  }
  return best;
}

/// One round of reweighted least squares from (a, b); `information` is left with the inverse covariance.
Eigen::Vector2d refine(const std::vector<Weighted>& weighted, const MetricFitParams& params,
                       const Eigen::Vector2d& ab, Eigen::Matrix2d& information) {
  const double shift_sigma = params.network_sigma + params.network_floor_pm;
  information.setZero();
  information(1, 1) = params.scale_prior / (shift_sigma * shift_sigma);
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Weighted& w : weighted) {
    const double r = std::abs(residual(w, ab(0), ab(1)));
    if (r > 2.0 * kOutlier) continue;
    const double huber = r <= params.huber ? 1.0 : params.huber / r;
    const double weight = w.weight * huber / (w.sigma * w.sigma);
    const Eigen::Vector2d row(w.sample->z, 1.0);
    information += weight * row * row.transpose();
    right += weight * w.sample->inverse_depth_pm * row;
  }
  // A little of the guess, so that samples of one depth still give a scale.
  const Eigen::Vector2d hold(1e-6 * information(0, 0) + 1e-12, 1e-6 * information(1, 1) + 1e-12);
  const Eigen::Matrix2d held = information + Eigen::Matrix2d(hold.asDiagonal());
  return held.inverse() * (right + hold.cwiseProduct(ab));
}

double medianOf(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Counts who agrees; the share of their weight.
double judge(const std::vector<Weighted>& weighted, MetricFit& fit) {
  double agreeing = 0.0;
  double total = 0.0;
  std::vector<double> relative;
  for (const Weighted& w : weighted) {
    total += w.weight;
    if (std::abs(residual(w, fit.a, fit.b)) > kOutlier) continue;
    agreeing += w.weight;
    relative.push_back(std::abs(fit.inverseDepth(w.sample->z) / w.sample->inverse_depth_pm - 1.0));
    if (w.sample->cue == Cue::kVo) ++fit.vo_points;
    if (w.sample->cue == Cue::kFloor) ++fit.floor_points;
    if (w.sample->cue == Cue::kGoal) ++fit.goal_points;
  }
  fit.residual = medianOf(relative);
  return total > 0.0 ? agreeing / total : 0.0;
}

}  // namespace

double MetricFit::inverseDepthSigma(double z) const {
  const Eigen::Vector2d row(z, 1.0);
  return std::sqrt(std::max(0.0, row.dot(covariance * row)));
}

std::optional<MetricFit> fitMetric(const std::vector<MetricSample>& samples, const MetricFitParams& params,
                                   const std::optional<MetricFit>& guess, Random& random) {
  const std::vector<Weighted> weighted = weigh(samples, params);
  if (static_cast<int>(weighted.size()) < params.min_samples) return std::nullopt;
  const Line start = firstGuess(weighted, params, guess, random);
  if (!std::isfinite(start.cost)) return std::nullopt;
  Eigen::Vector2d ab(start.a, start.b);
  Eigen::Matrix2d information;
  constexpr int kRounds = 6;
  for (int i = 0; i < kRounds; ++i) ab = refine(weighted, params, ab, information);
  if (!ab.allFinite() || ab(0) <= 0.0) return std::nullopt;
  MetricFit fit;
  fit.known = true;
  fit.a = ab(0);
  fit.b = ab(1);
  // Where the samples tell but one combination of a and b, the other stays as unsure as the scale itself.
  const Eigen::Vector2d least(1e-2 / (fit.a * fit.a), 1e-2);
  fit.covariance = (information + Eigen::Matrix2d(least.asDiagonal())).inverse();
  if (judge(weighted, fit) < params.min_inlier_share) return std::nullopt;
  return fit;
}

MetricFilter::MetricFilter(const MetricFitParams& params) : params_(validated(params, "metric fit")) {}

void MetricFilter::reset() {
  fit_ = {};
  jumps_ = 0;
  random_ = Random(1, "metric fit");
}

void MetricFilter::predict(Stamp stamp) {
  const double seconds = std::max(0.0, toSeconds(stamp - stamp_));
  const double share = params_.process_share * fit_.a;
  fit_.covariance(0, 0) += share * share * seconds;
  fit_.covariance(1, 1) += params_.process_shift_pm * params_.process_shift_pm * seconds;
}

void MetricFilter::correct(const MetricFit& measured) {
  const Eigen::Vector2d innovation(measured.a - fit_.a, measured.b - fit_.b);
  const Eigen::Matrix2d spread = fit_.covariance + measured.covariance;
  const double squared = innovation.dot(spread.inverse() * innovation);
  const bool is_jump = squared > params_.jump_sigma * params_.jump_sigma;
  jumps_ = is_jump ? jumps_ + 1 : 0;
  if (is_jump && jumps_ < params_.jumps_to_reset) return;
  if (is_jump) {
    fit_ = measured;
    jumps_ = 0;
    return;
  }
  const Eigen::Matrix2d gain = fit_.covariance * spread.inverse();
  const Eigen::Vector2d ab = Eigen::Vector2d(fit_.a, fit_.b) + gain * innovation;
  Eigen::Matrix2d covariance = (Eigen::Matrix2d::Identity() - gain) * fit_.covariance;
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  fit_ = measured;
  fit_.a = ab(0);
  fit_.b = ab(1);
  fit_.covariance = covariance;
}

const MetricFit& MetricFilter::update(Stamp stamp, const std::vector<MetricSample>& samples) {
  if (fit_.known) predict(stamp);
  stamp_ = stamp;
  const auto guess = fit_.known ? std::optional<MetricFit>(fit_) : std::nullopt;
  const std::optional<MetricFit> measured = fitMetric(samples, params_, guess, random_);
  if (measured) {
    renewed_ = stamp;
    if (fit_.known) {
      correct(*measured);
    } else {
      fit_ = *measured;
    }
  } else if (fit_.known) {
    fit_.vo_points = fit_.floor_points = fit_.goal_points = 0;
    if (toSeconds(stamp - renewed_) > params_.max_age_s) reset();
  }
  return fit_;
}

}  // namespace frugal_nav
