#include <algorithm>
#include <fstream>

#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include <frugal_nav/perception/face_detectors.hpp>

namespace frugal_nav {

struct CascadeFaceDetector::Impl {
  cv::CascadeClassifier cascade;
};

CascadeFaceDetector::CascadeFaceDetector(const CascadeFaceParams& params)
    : params_(params), impl_(std::make_unique<Impl>()) {
  validate(params, "cascade");
  const std::string& file = params.cascade_file;
  if (!std::ifstream(file)) {
    throw ConfigError("cascade file " + file +
                      " cannot be opened: install the package opencv-data, or set cascade_file");
  }
  bool loaded = false;
  try {
    loaded = impl_->cascade.load(file);
  } catch (const cv::Exception&) {
    loaded = false;  // no XML at all
  }
  if (!loaded) {
    throw ConfigError("cascade file " + file +
                      " holds no cascade OpenCV can read: install the package opencv-data again");
  }
}

CascadeFaceDetector::~CascadeFaceDetector() = default;

std::vector<Detection> CascadeFaceDetector::detect(const cv::Mat& bgr) {
  if (!accept(bgr)) return {};
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::equalizeHist(gray, gray);
  std::vector<cv::Rect> rectangles;
  std::vector<int> finds;
  impl_->cascade.detectMultiScale(gray, rectangles, finds, params_.scale_step, params_.min_neighbors, 0,
                                  cv::Size(params_.min_size_px, params_.min_size_px));
  std::vector<Detection> faces;
  for (std::size_t i = 0; i < rectangles.size(); ++i) {
    constexpr double kHalf = 4.0;  // finds that make a score of one half
    faces.push_back({0, "face", finds[i] / (finds[i] + kHalf), cv::Rect2d(rectangles[i])});
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return faces;
}

}  // namespace frugal_nav
