#include "painted_room.hpp"
#include "point_world.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace frugal_nav {
namespace {

Pinhole smallCamera() { return {320, 240, 265.0, 265.0, 159.5, 119.5, 0.0, 0.0, 0.0, 0.0, 0.0}; }

VisualOdometryParams withMethod(const std::string& method) {
  VisualOdometryParams params;
  params.features.method = method;
  return params;
}

/// A robot that drives through the painted room.
class Drive {
 public:
  explicit Drive(const VisualOdometryParams& params = {}, const Pinhole& camera = smallCamera())
      : odometry_(params, camera, cameraMount()), eye_(camera) {}

  cv::Mat look() const { return room_.look(toIsometry(truth_) * cameraMount(), eye_); }

  const VisualOdometryOutput& step(const Twist2& twist) {
    move(twist);
    return take(look());
  }
  void run(const Twist2& twist, int steps) {
    for (int i = 0; i < steps; ++i) step(twist);
  }
  void move(const Twist2& twist) {
    truth_ = truth_ * arcMotion(twist, 0.1);
    way_m_ += std::abs(twist.v_mps) * 0.1;
    stamp_ += fromSeconds(0.1);
  }
  const VisualOdometryOutput& take(const cv::Mat& image) {
    VisualInput input;
    input.stamp = stamp_;
    input.image = image;
    input.odom_from_base = toIsometry(truth_);
    last_ = odometry_.process(input);
    return last_;
  }
  void lookWith(const Pinhole& camera) { eye_ = camera; }
  void jumpBack(Duration span) { stamp_ -= span; }

  double error_m() const { return (last_.odom_from_base.translation().head<2>() - truth_.position()).norm(); }
  double way_m() const { return way_m_; }
  const VisualOdometryOutput& last() const { return last_; }
  VisualOdometry& odometry() { return odometry_; }
  Stamp stamp() const { return stamp_; }

 private:
  PaintedRoom room_{500007};
  VisualOdometry odometry_;
  Pinhole eye_;
  Pose2 truth_{-2.2, -1.0, 0.3};
  Stamp stamp_ = stampFromSeconds(10.0);
  double way_m_ = 0.0;
  VisualOdometryOutput last_;
};

constexpr Twist2 kAhead{0.3, 0.0};

class Method : public testing::TestWithParam<const char*> {};

TEST(VisualOdometry, FollowsADriveWithATurn) {
  Drive drive;
  drive.run(kAhead, 45);
  drive.run({0.1, 0.5}, 25);
  drive.run(kAhead, 20);
  EXPECT_EQ(drive.last().status.state, VisualState::kTracking);
  EXPECT_TRUE(drive.last().is_metric);
  EXPECT_LT(drive.error_m(), 0.02 * drive.way_m());
  EXPECT_NEAR(drive.last().status.scale, 1.0, 0.02);
  EXPECT_GT(drive.last().points.size(), 60U);
  EXPECT_LT(drive.error_m(), 3.0 * std::sqrt(drive.last().covariance(0, 0) + drive.last().covariance(1, 1)));
}

TEST_P(Method, FollowsAStraightDrive) {
  Drive drive(withMethod(GetParam()));
  drive.run(kAhead, 50);
  EXPECT_EQ(drive.last().status.state, VisualState::kTracking);
  // Matching starts late and with fewer features: its first course may be off by kAdjustedCourseError_rad.
  const double share = std::string(GetParam()) == "tracking" ? 0.02 : 0.08;
  EXPECT_LT(drive.error_m(), share * drive.way_m());
}

TEST_P(Method, TheSameImagesGiveTheSameBytes) {
  Drive first(withMethod(GetParam()));
  Drive second(withMethod(GetParam()));
  first.run(kAhead, 40);
  second.run(kAhead, 40);
  EXPECT_EQ(first.last().odom_from_camera.matrix(), second.last().odom_from_camera.matrix());
  EXPECT_EQ(first.last().status.state, VisualState::kTracking);
}

INSTANTIATE_TEST_SUITE_P(VisualOdometry, Method, testing::Values("tracking", "matching"),
                         [](const auto& name) { return std::string(name.param); });

TEST(VisualOdometry, PointsLieOnTheRoomsSurfaces) {
  Drive drive;
  drive.run(kAhead, 40);
  int off = 0;
  for (const VisualPoint& point : drive.last().points) {
    const Eigen::Vector3d& p = point.p_odom;
    const double to_surface = std::min({std::abs(3.0 - std::abs(p.x())), std::abs(3.0 - std::abs(p.y())),
                                        std::abs(p.z()), std::abs(3.0 - p.z())});
    off += to_surface > 3.0 * point.sigma_m + 0.02 ? 1 : 0;
    EXPECT_GT(point.sigma_m, 0.0);
  }
  EXPECT_LT(off, static_cast<int>(drive.last().points.size()) / 20);
}

TEST(VisualOdometry, BlackImagesAreLostAndItComesBack) {
  Drive drive;
  drive.run(kAhead, 20);
  ASSERT_EQ(drive.last().status.state, VisualState::kTracking);
  for (int i = 0; i < 5; ++i) {
    drive.move(kAhead);
    drive.take(cv::Mat(240, 320, CV_8UC1, cv::Scalar(2)));
    EXPECT_EQ(drive.last().status.state, VisualState::kLost);
    EXPECT_EQ(drive.last().status.reason, VisualReason::kDark);
    EXPECT_TRUE(drive.last().points.empty());
    EXPECT_LT(drive.error_m(), 0.03) << "the pose stays behind the wheels";
  }
  drive.run(kAhead, 20);
  EXPECT_EQ(drive.last().status.state, VisualState::kTracking);
  EXPECT_LT(drive.error_m(), 0.05);
}

TEST(VisualOdometry, NamesSaturatedAndEvenImages) {
  Drive drive;
  drive.take(cv::Mat(240, 320, CV_8UC3, cv::Scalar(255, 255, 255)));
  EXPECT_EQ(drive.last().status.reason, VisualReason::kSaturated);
  drive.move(kAhead);
  drive.take(cv::Mat(240, 320, CV_8UC3, cv::Scalar(120, 120, 120)));
  EXPECT_EQ(drive.last().status.reason, VisualReason::kNoContrast);
  EXPECT_EQ(drive.last().status.state, VisualState::kLost);
}

TEST(VisualOdometry, NamesBlur) {
  Drive drive;
  drive.run(kAhead, 20);
  drive.move({0.0, 3.0});
  cv::Mat smeared;
  cv::blur(drive.look(), smeared, cv::Size(61, 61));
  drive.take(smeared);
  EXPECT_EQ(drive.last().status.state, VisualState::kLost);
  EXPECT_EQ(drive.last().status.reason, VisualReason::kBlurred);
}

TEST(VisualOdometry, RefusesWhatIsNoImage) {
  Drive drive;
  drive.take(cv::Mat());
  EXPECT_EQ(drive.last().status.reason, VisualReason::kBadImage);
  for (const int type : {CV_32FC1, CV_8UC2, CV_16SC1}) {
    drive.move(kAhead);
    drive.take(cv::Mat(240, 320, type, cv::Scalar::all(1)));
    EXPECT_EQ(drive.last().status.reason, VisualReason::kBadImage) << type;
  }
  drive.move(kAhead);
  drive.take(cv::Mat(3, 4, CV_8UC1, cv::Scalar(1)));
  EXPECT_EQ(drive.last().status.reason, VisualReason::kBadImage);
}

TEST(VisualOdometry, TakesMonoColourAlphaAndSixteenBits) {
  for (const int code :
       {-1, static_cast<int>(cv::COLOR_GRAY2BGR), static_cast<int>(cv::COLOR_GRAY2BGRA), -2}) {
    Drive drive;
    for (int i = 0; i < 15; ++i) {
      drive.move(kAhead);
      cv::Mat image = drive.look();
      if (code >= 0) cv::cvtColor(image, image, code);
      if (code == -2) image.convertTo(image, CV_16U, 257.0);
      drive.take(image);
    }
    EXPECT_EQ(drive.last().status.state, VisualState::kTracking) << code;
    EXPECT_LT(drive.error_m(), 0.03);
  }
}

TEST(VisualOdometry, AResizedCameraIsStillCalibrated) {
  Drive drive({}, testCamera());  // calibrated at 640x480
  drive.lookWith(testCamera().scaled(320, 240));
  drive.run(kAhead, 40);
  EXPECT_EQ(drive.last().status.state, VisualState::kTracking);
  EXPECT_LT(drive.error_m(), 0.02 * drive.way_m());
}

TEST(VisualOdometry, AnUncalibratedCameraIsAConfigError) {
  Pinhole camera = smallCamera();
  camera.fx = camera.fy = 0.0;
  EXPECT_THROW(VisualOdometry({}, camera, cameraMount()), ConfigError);
  Drive drive;
  EXPECT_THROW(drive.odometry().setCamera(camera), ConfigError);
  VisualOdometryParams params;
  params.features.method = "guessing";
  EXPECT_THROW(VisualOdometry(params, smallCamera(), cameraMount()), ConfigError);
}

TEST(VisualOdometry, TimeThatJumpsBackStartsAnew) {
  Drive drive;
  drive.run(kAhead, 20);
  ASSERT_EQ(drive.last().status.state, VisualState::kTracking);
  drive.jumpBack(fromSeconds(5.0));
  drive.step(kAhead);
  EXPECT_EQ(drive.last().status.state, VisualState::kInitializing);
  EXPECT_EQ(drive.last().status.reason, VisualReason::kTimeJumpedBack);
  EXPECT_TRUE(drive.last().points.empty());
  drive.run(kAhead, 15);
  EXPECT_EQ(drive.last().status.state, VisualState::kTracking);
}

TEST(VisualOdometry, WithoutWheelsItTracksButIsNotMetric) {
  Drive drive;
  for (int i = 0; i < 20; ++i) {
    drive.move(kAhead);
    VisualInput input;
    input.stamp = drive.stamp();
    input.image = drive.look();
    const VisualOdometryOutput output = drive.odometry().process(input);
    if (i < 19) continue;
    EXPECT_EQ(output.status.state, VisualState::kTracking);
    EXPECT_EQ(output.status.reason, VisualReason::kNoWheels);
    EXPECT_FALSE(output.is_metric);
  }
}

TEST(VisualOdometry, WheelsThatAreNotFiniteCountAsMissing) {
  Drive drive;
  VisualInput input;
  input.stamp = drive.stamp();
  input.image = drive.look();
  input.odom_from_base = Eigen::Isometry3d(Eigen::Translation3d(std::nan(""), 0.0, 0.0));
  EXPECT_TRUE(drive.odometry().process(input).odom_from_base.matrix().allFinite());
}

TEST(VisualOdometry, ARegionGetsMoreFeatures) {
  const cv::Rect region(110, 70, 100, 80);
  int inside = 0;
  Drive drive;
  for (int i = 0; i < 5; ++i) {
    drive.move(kAhead);
    VisualInput input;
    input.stamp = drive.stamp();
    input.image = drive.look();
    input.odom_from_base = Eigen::Isometry3d::Identity();
    input.region = region;
    inside = 0;
    for (const cv::Point2f& pixel : drive.odometry().process(input).features)
      inside += region.contains(cv::Point(pixel)) ? 1 : 0;
  }
  EXPECT_GE(inside, 120);  // a tenth of the image would get 30 of 300
}

}  // namespace
}  // namespace frugal_nav
