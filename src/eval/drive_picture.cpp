#include "drive_picture.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kPixelsPerMetre = 80.0;
constexpr double kBorder_m = 0.3;
const cv::Scalar kGrey(150, 150, 150);
const cv::Scalar kBlack(0, 0, 0);
const cv::Scalar kGreen(40, 150, 40);
const cv::Scalar kBlue(220, 120, 20);
const cv::Scalar kRed(60, 60, 220);
const cv::Scalar kMagenta(200, 40, 200);
const cv::Scalar kOrange(0, 140, 255);

/// A floor plan seen from above, x to the right, y up.
class Plan {
 public:
  explicit Plan(const Eigen::AlignedBox2d& floor)
      : corner_(floor.min().x() - kBorder_m, floor.max().y() + kBorder_m) {
    const Eigen::Vector2d size = floor.sizes() + Eigen::Vector2d::Constant(2.0 * kBorder_m);
    picture = cv::Mat(static_cast<int>(size.y() * kPixelsPerMetre),
                      static_cast<int>(size.x() * kPixelsPerMetre), CV_8UC3, cv::Scalar::all(255));
  }

  cv::Point at(const Eigen::Vector2d& p) const {
    return {static_cast<int>(std::lround((p.x() - corner_.x()) * kPixelsPerMetre)),
            static_cast<int>(std::lround((corner_.y() - p.y()) * kPixelsPerMetre))};
  }
  void fill(const Solid& solid, const cv::Scalar& colour) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& corner : solid.outline()) corners.push_back(at(corner));
    cv::fillConvexPoly(picture, corners, colour, cv::LINE_AA);
  }
  void line(const Path2& poses, const Pose2& world_from_frame, const cv::Scalar& colour, int thickness = 2) {
    for (std::size_t i = 1; i < poses.size(); ++i) {
      cv::line(picture, at(world_from_frame * poses[i - 1].position()),
               at(world_from_frame * poses[i].position()), colour, thickness, cv::LINE_AA);
    }
  }
  void circle(const Eigen::Vector2d& p, double radius_m, const cv::Scalar& colour, int thickness) {
    cv::circle(picture, at(p), static_cast<int>(radius_m * kPixelsPerMetre), colour, thickness, cv::LINE_AA);
  }

  cv::Mat picture;

 private:
  Eigen::Vector2d corner_;
};

void drawRobot(const Pose2& world_from_base, const cv::Scalar& colour, Plan& plan) {
  constexpr double kLength_m = 0.28;
  constexpr double kWidth_m = 0.25;
  Solid body;
  body.world_from_solid = world_from_base * Pose2{-0.02, 0.0, 0.0};
  body.size_m = {kLength_m, kWidth_m};
  plan.fill(body, colour);
  cv::line(plan.picture, plan.at(world_from_base.position()),
           plan.at(world_from_base * Eigen::Vector2d(0.25, 0.0)), kBlack, 2, cv::LINE_AA);
}

cv::Mat drawPlan(const CameraLayout& layout, const CameraDriveRecord& record, const CameraDriver& driver) {
  Plan plan(layout.floor);
  for (const Solid& solid : layout.solids) {
    if (!solid.overhang) plan.fill(solid, kGrey);
  }
  for (const Solid& solid : layout.obstacles) plan.fill(solid, cv::Scalar(90, 90, 90));
  for (const Eigen::Vector2d& p : driver.remembered()) plan.circle(layout.start * p, 0.02, kRed, cv::FILLED);
  plan.line(record.truth, {}, kGreen);
  plan.line(record.believed, {}, kBlue, 1);
  plan.line(driver.path(), layout.start, kMagenta, 1);
  for (std::size_t i = 0; i < record.walker.size(); i += 5) plan.circle(record.walker[i], 0.03, kOrange, 1);
  if (!record.walker.empty()) plan.circle(record.walker.back(), 0.22, kOrange, 2);
  plan.circle(layout.p_person, 0.16, kBlue, 2);
  plan.circle(layout.p_stand_off, 0.30, kGreen, 1);
  drawRobot(record.truth.back(), kGreen, plan);
  return plan.picture;
}

}  // namespace

void writeDrivePicture(const std::string& path, const CameraLayout& layout, const CameraDriveRecord& record,
                       const CameraDriver& driver, const std::string& title) {
  const cv::Mat plan = drawPlan(layout, record, driver);
  const cv::Mat view = driver.lastView();
  constexpr int kLine_px = 22;
  const int text_px = 3 * kLine_px;
  cv::Mat sheet(text_px + std::max(plan.rows, view.rows), plan.cols + view.cols, CV_8UC3,
                cv::Scalar::all(255));
  plan.copyTo(sheet(cv::Rect(0, text_px, plan.cols, plan.rows)));
  if (!view.empty()) view.copyTo(sheet(cv::Rect(plan.cols, text_px, view.cols, view.rows)));
  int row = kLine_px - 6;
  const std::string touched = record.touched.empty() ? "" : ", touched " + record.touched;
  for (const std::string& text :
       {title + touched, record.outcome + ": " + record.reason, driver.activity()}) {
    cv::putText(sheet, text, {6, row}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kBlack, 1, cv::LINE_AA);
    row += kLine_px;
  }
  if (!cv::imwrite(path, sheet)) throw ConfigError("cannot write " + path);
}

}  // namespace frugal_nav::eval
