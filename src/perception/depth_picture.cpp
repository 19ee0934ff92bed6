#include <algorithm>
#include <cmath>
#include <cstdio>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/depth_picture.hpp>

namespace frugal_nav {
namespace {

const cv::Scalar kFloor(60, 200, 60);
const cv::Scalar kLine(0, 0, 255);
const cv::Scalar kNear(60, 60, 230);
const cv::Scalar kOpen(80, 220, 80);
const cv::Scalar kGap(255, 220, 0);
const cv::Scalar kObstacle(0, 150, 255);

class Picture {
 public:
  Picture(const cv::Mat& bgr, const DepthFrame& frame)
      : frame_(frame), image_(bgr.clone()), cell_px_(0.0), font_(std::max(0.4, bgr.cols / 1000.0)) {
    if (!frame.floor.empty()) cell_px_ = static_cast<double>(bgr.cols) / frame.floor.cols;
  }

  cv::Mat draw() {
    if (!frame_.fault.empty()) {
      write(frame_.fault, {8, image_.rows / 2}, kNear);
      return image_;
    }
    tintFloor();
    drawLines();
    drawProfile();
    drawGap();
    drawObstacle();
    return image_;
  }

 private:
  void write(const std::string& text, const cv::Point& at, const cv::Scalar& colour) {
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, font_, cv::Scalar::all(0), 3, cv::LINE_AA);
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, font_, colour, 1, cv::LINE_AA);
  }

  void tintFloor() {
    cv::Mat floor;
    cv::resize(frame_.floor, floor, image_.size(), 0.0, 0.0, cv::INTER_NEAREST);
    cv::Mat tinted;
    cv::addWeighted(image_, 0.75, cv::Mat(image_.size(), CV_8UC3, kFloor), 0.25, 0.0, tinted);
    tinted.copyTo(image_, floor);
  }

  void drawLines() {
    for (std::size_t i = 0; i < frame_.contacts.size(); ++i) {
      const FloorContact& contact = frame_.contacts[i];
      if (contact.state != FloorContact::State::kContact) continue;
      const int x = cvRound((static_cast<double>(i) + 0.5) * cell_px_);
      cv::line(image_, {x - 1, cvRound(contact.image_row)}, {x + 1, cvRound(contact.image_row)}, kLine, 2);
    }
  }

  /// Bars as long as the column is near.
  void drawProfile() {
    const auto& nearest = frame_.profile.nearest;
    if (nearest.empty()) return;
    const float largest = std::max(1e-6F, *std::max_element(nearest.begin(), nearest.end()));
    const int full = image_.rows / 6;
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      const auto column = static_cast<double>(i);
      const int length = 3 + cvRound(static_cast<double>(nearest[i] / largest) * full);
      const cv::Rect bar(cvFloor(column * cell_px_), image_.rows - length, std::max(1, cvRound(cell_px_)),
                         length);
      cv::rectangle(image_, bar & cv::Rect({0, 0}, image_.size()), frame_.near[i] != 0 ? kNear : kOpen,
                    cv::FILLED);
    }
  }

  void drawGap() {
    const GapSighting& gap = frame_.gap;
    const int middle = image_.rows / 2;
    if (!gap.found) {
      write("no gap: " + gap.reason, {8, cvRound(30.0 * font_)}, kGap);
      return;
    }
    const int left = cvRound(gap.left_column_px);
    const int right = cvRound(gap.right_column_px);
    for (const int x : {left, right}) cv::line(image_, {x, image_.rows / 4}, {x, image_.rows - 1}, kGap, 2);
    cv::arrowedLine(image_, {(left + right) / 2, image_.rows - 1}, {(left + right) / 2, middle}, kGap, 2,
                    cv::LINE_AA, 0, 0.1);
    char text[96];
    std::snprintf(text, sizeof(text), "gap %.2f m wide at %.1f m, block %d", gap.width_m, gap.depth_m,
                  gap.block);
    write(text, {8, cvRound(30.0 * font_)}, kGap);
  }

  void drawObstacle() {
    const NearestObstacle& o = frame_.obstacle;
    if (!o.found) {
      write(o.reason.empty() ? "nothing near" : o.reason, {8, cvRound(65.0 * font_)}, kObstacle);
      return;
    }
    cv::rectangle(image_, cv::Rect(o.left_px, o.top_px, o.width_px, o.height_px), kObstacle, 2);
    char text[128];
    const double speed = o.velocity_mps.norm();
    std::snprintf(text, sizeof(text), "nearest %.2f +- %.2f m (%s)%s", o.distance_m, o.sigma_m,
                  o.source.c_str(), speed > 0.0 ? ", moving" : "");
    write(text, {8, cvRound(65.0 * font_)}, kObstacle);
  }

  const DepthFrame& frame_;
  cv::Mat image_;
  double cell_px_;
  double font_;
};

}  // namespace

cv::Mat drawDepthFrame(const cv::Mat& bgr, const DepthFrame& frame) { return Picture(bgr, frame).draw(); }

}  // namespace frugal_nav
