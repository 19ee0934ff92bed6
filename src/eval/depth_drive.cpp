#include "depth_drive.hpp"

#include <utility>

namespace frugal_nav::eval {
namespace {

class Answer : public DepthNetwork {
 public:
  Answer(std::shared_ptr<DepthPrediction> prediction, bool is_metric)
      : prediction_(std::move(prediction)), is_metric_(is_metric) {}
  DepthPrediction infer(const cv::Mat&) override { return *prediction_; }
  bool isMetric() const override { return is_metric_; }

 private:
  std::shared_ptr<DepthPrediction> prediction_;
  bool is_metric_;
};

}  // namespace

SharedDepthNetwork::SharedDepthNetwork(std::unique_ptr<DepthNetwork> network)
    : network_(std::move(network)), prediction_(std::make_shared<DepthPrediction>()) {}

void SharedDepthNetwork::show(const cv::Mat& bgr) { *prediction_ = network_->infer(bgr); }

std::unique_ptr<DepthNetwork> SharedDepthNetwork::answer() const {
  return std::make_unique<Answer>(prediction_, network_->isMetric());
}

std::optional<cv::Rect> regionOf(const NearestObstacle& obstacle) {
  if (!obstacle.found || obstacle.width_px <= 0 || obstacle.height_px <= 0) return std::nullopt;
  return cv::Rect(obstacle.left_px, obstacle.top_px, obstacle.width_px, obstacle.height_px);
}

std::vector<MetricPoint> metricPoints(const VisualOdometryOutput& output,
                                      const Eigen::Isometry3d& base_from_optical,
                                      const Pose2& odom_from_base) {
  std::vector<MetricPoint> points;
  if (!output.is_metric) return points;
  const Eigen::Isometry3d odom_from_optical = toIsometry(odom_from_base) * base_from_optical;
  for (const VisualPoint& point : output.points) {
    points.push_back({cv::Point2f(static_cast<float>(point.pixel.x()), static_cast<float>(point.pixel.y())),
                      odom_from_optical * point.p_camera, point.sigma_m});
  }
  return points;
}

}  // namespace frugal_nav::eval
