#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/odometry/visual_estimator.hpp>
#include <frugal_nav/odometry/visual_front_end.hpp>
#include <frugal_nav/odometry/visual_image.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav {
namespace {

constexpr int kSharpnessPeriod = 5;  // images between two looks at the usual sharpness
constexpr double kSharpnessGain = 0.2;
constexpr double kDimShare = 3.0;  // below this multiple of the dark level, lost features are put to darkness

/// How the pose's uncertainty grows with the way [m^2/m, rad^2/m] and the turn [rad^2/rad].
struct Growth {
  double position;
  double heading;
  double turn;
};
constexpr Growth kVisualGrowth{1e-4, 1e-5, 1e-5};  // 1 cm and 0.2 degrees after one metre
constexpr Growth kWheelGrowth{4e-4, 1e-4, 9e-4};   // wheels that slip: 2 cm, and 2 degrees a turn of 1 rad

Pinhole checked(const Pinhole& camera) {
  const std::string fault = camera.fault();
  if (!fault.empty()) throw ConfigError("visual odometry: " + fault);
  return camera;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

struct VisualOdometry::Impl {
  Impl(const VisualOdometryParams& p, const Pinhole& c, const Eigen::Isometry3d& mount)
      : params(p),
        calibrated(checked(c)),
        camera(c),
        base_from_camera(mount),
        front_end(makeVisualFrontEnd(p.features)),
        estimator(p, c.fx, mount) {}

  VisualOdometryOutput process(const VisualInput& input);
  VisualReason takeImage(const cv::Mat& image, cv::Mat& gray);
  RayMap follow(const cv::Mat& gray, const VisualInput& input,
                const std::optional<Eigen::Isometry3d>& wheels_from_camera);
  VisualReason diagnose(const cv::Mat& gray, VisualReason reason) const;
  void watchSharpness(const cv::Mat& gray);
  void forgetImages();
  void growCovariance(const Eigen::Isometry3d& odom_from_base_before, bool is_visual);
  VisualOdometryOutput output(const VisualInput& input, const VisualUpdate& update, const RayMap& rays);

  VisualOdometryParams params;
  Pinhole calibrated;
  Pinhole camera;  // of the present image size
  Eigen::Isometry3d base_from_camera;
  std::unique_ptr<VisualFrontEnd> front_end;
  VisualEstimator estimator;
  std::optional<VisualOdometryOutput> last;
  std::vector<VisualFeature> features;
  Matrix6d covariance = Matrix6d::Zero();
  double usual_sharpness = 0.0;
  int images = 0;
};

VisualOdometry::VisualOdometry(const VisualOdometryParams& params, const Pinhole& camera,
                               const Eigen::Isometry3d& base_from_camera) {
  validate(params, "visual odometry");
  impl_ = std::make_unique<Impl>(params, camera, base_from_camera);
}
VisualOdometry::~VisualOdometry() = default;
VisualOdometry::VisualOdometry(VisualOdometry&&) noexcept = default;
VisualOdometry& VisualOdometry::operator=(VisualOdometry&&) noexcept = default;

void VisualOdometry::reset() {
  impl_ = std::make_unique<Impl>(impl_->params, impl_->calibrated, impl_->base_from_camera);
}

void VisualOdometry::setCamera(const Pinhole& camera) {
  impl_->calibrated = checked(camera);
  impl_->camera = camera;
  impl_->estimator.setFocal(camera.fx);
  impl_->forgetImages();
}

VisualOdometryOutput VisualOdometry::process(const VisualInput& input) {
  const bool jumped = impl_->last && input.stamp < impl_->last->stamp;
  if (impl_->last && input.stamp == impl_->last->stamp) return *impl_->last;
  if (jumped) reset();
  VisualOdometryOutput out = impl_->process(input);
  if (jumped && out.status.state == VisualState::kInitializing)
    out.status.reason = VisualReason::kTimeJumpedBack;
  impl_->last = out;
  return out;
}

VisualOdometryOutput VisualOdometry::Impl::process(const VisualInput& input) {
  std::optional<Eigen::Isometry3d> wheels_from_camera;
  if (input.odom_from_base && input.odom_from_base->matrix().allFinite())
    wheels_from_camera = *input.odom_from_base * base_from_camera;
  cv::Mat gray;
  VisualUpdate update;
  update.state = VisualState::kLost;
  update.reason = takeImage(input.image, gray);
  RayMap rays;
  if (update.reason == VisualReason::kNone) {
    rays = follow(gray, input, wheels_from_camera);
    if (static_cast<int>(rays.size()) < params.checks.min_features)
      update.reason = diagnose(gray, VisualReason::kFewFeatures);
  }
  if (update.reason != VisualReason::kNone) {
    forgetImages();
    estimator.lose(wheels_from_camera);
  } else {
    update = estimator.update(rays, wheels_from_camera);
    if (update.state == VisualState::kLost) update.reason = diagnose(gray, update.reason);
    watchSharpness(gray);
  }
  return output(input, update, rays);
}

VisualReason VisualOdometry::Impl::takeImage(const cv::Mat& image, cv::Mat& gray) {
  gray = toGray(image);
  constexpr int kLeastSide_px = 64;
  if (gray.cols < kLeastSide_px || gray.rows < kLeastSide_px) return VisualReason::kBadImage;
  if (gray.cols != camera.width_px || gray.rows != camera.height_px) {
    camera = calibrated.scaled(gray.cols, gray.rows);
    estimator.setFocal(camera.fx);
    forgetImages();
  }
  return findImageFault(gray, params.checks);
}

RayMap VisualOdometry::Impl::follow(const cv::Mat& gray, const VisualInput& input,
                                    const std::optional<Eigen::Isometry3d>& wheels_from_camera) {
  Eigen::Matrix3d now_from_last = Eigen::Matrix3d::Identity();
  if (const auto motion = estimator.wheelMotion(wheels_from_camera))
    now_from_last = motion->linear().transpose();
  const PixelMotion expected = [&](const cv::Point2f& pixel) {
    const auto ray = camera.lookThrough({pixel.x, pixel.y});
    if (!ray) return pixel;
    const auto turned = camera.project(now_from_last * ray->point.homogeneous());
    return turned ? cv::Point2f(static_cast<float>(turned->x()), static_cast<float>(turned->y())) : pixel;
  };
  features = front_end->process(gray, expected, input.region);
  RayMap rays;
  for (const VisualFeature& feature : features) {
    if (const auto ray = camera.lookThrough({feature.pixel.x, feature.pixel.y}))
      rays[feature.id] = ray->point;
  }
  return rays;
}

VisualReason VisualOdometry::Impl::diagnose(const cv::Mat& gray, VisualReason reason) const {
  if (cv::mean(gray)[0] < kDimShare * params.checks.dark_level) return VisualReason::kDark;
  if (sharpness(gray) < params.checks.blur_drop * usual_sharpness) return VisualReason::kBlurred;
  return reason;
}

void VisualOdometry::Impl::watchSharpness(const cv::Mat& gray) {
  if (images++ % kSharpnessPeriod != 0) return;
  const double now = sharpness(gray);
  usual_sharpness = usual_sharpness == 0.0 ? now : usual_sharpness + kSharpnessGain * (now - usual_sharpness);
}

void VisualOdometry::Impl::forgetImages() {
  front_end->reset();
  features.clear();
}

void VisualOdometry::Impl::growCovariance(const Eigen::Isometry3d& odom_from_base_before, bool is_visual) {
  const Eigen::Isometry3d odom_from_base = estimator.odomFromCamera() * base_from_camera.inverse();
  const Eigen::Vector3d moved = odom_from_base.translation() - odom_from_base_before.translation();
  const double turned_rad =
      Eigen::AngleAxisd(odom_from_base_before.linear().transpose() * odom_from_base.linear()).angle();
  const Growth& growth = is_visual ? kVisualGrowth : kWheelGrowth;
  // A wrong direction becomes a wrong place as the robot moves on.
  Matrix6d by_pose = Matrix6d::Identity();
  by_pose.topRightCorner<3, 3>() = -cross(moved);
  covariance = by_pose * covariance * by_pose.transpose();
  covariance.diagonal().head<3>().array() += growth.position * moved.norm();
  covariance.diagonal().tail<3>().array() += growth.heading * moved.norm() + growth.turn * turned_rad;
}

VisualOdometryOutput VisualOdometry::Impl::output(const VisualInput& input, const VisualUpdate& update,
                                                  const RayMap& rays) {
  const bool is_visual = update.state == VisualState::kTracking;
  if (last) growCovariance(last->odom_from_base, is_visual);
  VisualOdometryOutput out;
  out.stamp = input.stamp;
  out.odom_from_camera = estimator.odomFromCamera();
  out.odom_from_base = out.odom_from_camera * base_from_camera.inverse();
  out.covariance = covariance;
  if (is_visual) {
    // From the camera's frame to the axes of odom; the lever to the base is short against what has grown.
    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = out.odom_from_camera.linear();
    turn.bottomRightCorner<3, 3>() = out.odom_from_camera.linear();
    out.covariance += turn * update.covariance * turn.transpose();
  }
  out.status.state = update.state;
  out.status.reason = update.reason;
  out.status.features = static_cast<int>(rays.size());
  out.status.inliers = update.inliers;
  out.is_metric = is_visual && estimator.isMetric();
  out.is_keyframe = update.is_keyframe;
  if (const auto scale = estimator.scale(); scale && is_visual) {
    out.status.scale = scale->scale;
    out.status.scale_sigma = scale->sigma;
  }
  out.retired = estimator.map().takeRetired();
  const Eigen::Isometry3d camera_from_odom = out.odom_from_camera.inverse();
  for (const VisualFeature& feature : features) {
    out.features.push_back(feature.pixel);
    if (!is_visual) continue;
    const auto landmark = estimator.map().landmarks().find(feature.id);
    const auto ray = rays.find(feature.id);
    if (landmark == estimator.map().landmarks().end() || ray == rays.end()) continue;
    const Eigen::Vector3d p = camera_from_odom * landmark->second.p_odom;
    const bool fits = p.z() > 0.0 && camera.fx * (p.head<2>() / p.z() - ray->second).norm() <=
                                         params.map.max_reprojection_px;
    if (!fits) continue;
    out.points.push_back({feature.id,
                          {feature.pixel.x, feature.pixel.y},
                          p,
                          landmark->second.p_odom,
                          landmark->second.sigma_m});
  }
  return out;
}

}  // namespace frugal_nav
