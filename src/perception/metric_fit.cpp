#include "detector_support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include <frugal_nav/perception/metric_fit.hpp>

namespace frugal_nav {
namespace {

constexpr double kOutlier = 3.0;  // sigmas from which a sample does not agree

double medianOf(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Samples with the weight of their cue: many of one cue share the network's error.
struct Weighted {
  const MetricSample* sample;
  double weight;  // 1 for an independent sample
};

/// The fit turned about: z = alpha / depth + beta. The network is the noisy one of the two, and a regression
/// on what is noisy would flatten the slope (errors in variables).
struct Line {
  double alpha = 0.0;
  double beta = 0.0;

  double at(double inverse_depth_pm) const { return alpha * inverse_depth_pm + beta; }
  bool isSound() const { return alpha > 0.0 && std::isfinite(alpha) && std::isfinite(beta); }
};

std::vector<Weighted> weigh(const std::vector<MetricSample>& samples, const MetricFitParams& params) {
  std::array<int, 3> counts{};
  std::vector<Weighted> weighted;
  for (const MetricSample& sample : samples) {
    if (!std::isfinite(sample.z) || !std::isfinite(sample.inverse_depth_pm) ||
        !(sample.inverse_depth_pm > 0.0) || !(sample.sigma_pm >= 0.0))
      continue;
    ++counts[static_cast<std::size_t>(sample.cue)];
    weighted.push_back({&sample, 1.0});
  }
  for (Weighted& w : weighted) {
    const int count = counts[static_cast<std::size_t>(w.sample->cue)];
    w.weight = std::min(1.0, params.effective_samples / count);
  }
  return weighted;
}

/// Standard deviation of z about a line: the network's and the sample's errors.
double sigmaOf(const MetricSample& sample, const Line& line, const MetricFitParams& params) {
  const double network = params.network_sigma * sample.inverse_depth_pm + params.network_floor_pm;
  return line.alpha * std::hypot(network, sample.sigma_pm);
}

double residual(const Weighted& w, const Line& line, const MetricFitParams& params) {
  return (w.sample->z - line.at(w.sample->inverse_depth_pm)) / sigmaOf(*w.sample, line, params);
}

/// Standard deviation of the shift b before anything is seen [1/m].
double shiftSigma(const std::vector<Weighted>& weighted, const MetricFitParams& params) {
  std::vector<double> inverse;
  for (const Weighted& w : weighted) inverse.push_back(w.sample->inverse_depth_pm);
  return params.shift_share * medianOf(inverse);
}

/// Cost of a hypothesis: squares, cut off where a sample disagrees (MSAC), and its shift.
double costOf(const std::vector<Weighted>& weighted, const Line& line, double shift_sigma,
              const MetricFitParams& params) {
  double cost = std::pow(line.beta / (line.alpha * shift_sigma), 2);
  for (const Weighted& w : weighted) {
    const double r = residual(w, line, params);
    cost += w.weight * std::min(r * r, kOutlier * kOutlier);
  }
  return cost;
}

std::optional<Line> firstGuess(const std::vector<Weighted>& weighted, const MetricFitParams& params,
                               const std::optional<MetricFit>& guess, Random& random) {
  const double shift_sigma = shiftSigma(weighted, params);
  std::optional<Line> best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Line& line) {
    if (!line.isSound()) return;
    const double cost = costOf(weighted, line, shift_sigma, params);
    if (cost < least) {
      least = cost;
      best = line;
    }
  };
  if (guess && guess->known) consider({1.0 / guess->a, -guess->b / guess->a});
  const int last = static_cast<int>(weighted.size()) - 1;
  for (int i = 0; i < params.hypotheses; ++i) {
    const MetricSample& p = *weighted[static_cast<std::size_t>(random.integer(0, last))].sample;
    const MetricSample& q = *weighted[static_cast<std::size_t>(random.integer(0, last))].sample;
    consider({p.z / p.inverse_depth_pm, 0.0});
    if (std::abs(q.inverse_depth_pm - p.inverse_depth_pm) < 1e-9) continue;
    const double alpha = (q.z - p.z) / (q.inverse_depth_pm - p.inverse_depth_pm);
    consider({alpha, p.z - alpha * p.inverse_depth_pm});
  }
  return best;
}

/// One round of reweighted least squares; `information` is left with that of (alpha, beta).
Line refine(const std::vector<Weighted>& weighted, const MetricFitParams& params, const Line& line,
            Eigen::Matrix2d& information) {
  const double beta_sigma = line.alpha * shiftSigma(weighted, params);
  information.setZero();
  information(1, 1) = 1.0 / (beta_sigma * beta_sigma);
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Weighted& w : weighted) {
    const double r = std::abs(residual(w, line, params));
    if (r > 2.0 * kOutlier) continue;
    const double huber = r <= params.huber ? 1.0 : params.huber / r;
    const double sigma = sigmaOf(*w.sample, line, params);
    const double weight = w.weight * huber / (sigma * sigma);
    const Eigen::Vector2d row(w.sample->inverse_depth_pm, 1.0);
    information += weight * row * row.transpose();
    right += weight * w.sample->z * row;
  }
  const Eigen::Vector2d solved = information.ldlt().solve(right);
  return {solved(0), solved(1)};
}

/// The line as a and b, with the covariance carried over to first order.
MetricFit turned(const Line& line, const Eigen::Matrix2d& information) {
  MetricFit fit;
  fit.known = true;
  fit.a = 1.0 / line.alpha;
  fit.b = -line.beta / line.alpha;
  Eigen::Matrix2d by_line;  // derivative of (a, b) by (alpha, beta)
  by_line << -fit.a * fit.a, 0.0, -fit.b * fit.a, -fit.a;
  fit.covariance = by_line * information.inverse() * by_line.transpose();
  return fit;
}

/// Counts who agrees; the share of their weight.
double judge(const std::vector<Weighted>& weighted, const MetricFitParams& params, const Line& line,
             MetricFit& fit) {
  double agreeing = 0.0;
  double total = 0.0;
  std::vector<double> relative;
  for (const Weighted& w : weighted) {
    total += w.weight;
    if (std::abs(residual(w, line, params)) > kOutlier) continue;
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
  std::optional<Line> line = firstGuess(weighted, params, guess, random);
  if (!line) return std::nullopt;
  Eigen::Matrix2d information;
  constexpr int kRounds = 6;
  for (int i = 0; i < kRounds; ++i) {
    line = refine(weighted, params, *line, information);
    if (!line->isSound()) return std::nullopt;
  }
  MetricFit fit = turned(*line, information);
  if (judge(weighted, params, *line, fit) < params.min_inlier_share || fit.residual > params.max_residual)
    return std::nullopt;
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
