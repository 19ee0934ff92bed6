#include "marker_edges.hpp"

#include <algorithm>

#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>

namespace frugal_nav {
namespace {

using Quad = std::vector<cv::Point2f>;

MarkerCorners toCorners(int id, const Quad& quad) {
  MarkerCorners marker;
  marker.id = id;
  for (std::size_t i = 0; i < 4; ++i) marker.pixels[i] = Eigen::Vector2d(quad[i].x, quad[i].y);
  return marker;
}

}  // namespace

struct MarkerDetector::Impl {
  MarkerDetectorParams params;
  std::vector<int> whitelist;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  int cells = 0;

  bool isListed(int id) const {
    return whitelist.empty() || std::find(whitelist.begin(), whitelist.end(), id) != whitelist.end();
  }

  cv::Ptr<cv::aruco::DetectorParameters> settingsFor(const cv::Mat& image) const {
    auto settings = cv::aruco::DetectorParameters::create();
    settings->adaptiveThreshWinSizeMin = params.threshold_window_min_px;
    settings->adaptiveThreshWinSizeMax = params.threshold_window_max_px;
    settings->adaptiveThreshWinSizeStep = params.threshold_window_step_px;
    settings->minMarkerPerimeterRate = 4.0 * params.min_side_px / std::max(image.cols, image.rows);
    settings->errorCorrectionRate = params.error_correction_share;
    settings->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
    return settings;
  }
};

MarkerDetector::MarkerDetector(const MarkerDetectorParams& params, const std::vector<int>& whitelist)
    : impl_(std::make_unique<Impl>()) {
  validate(params, "marker detector");
  const MarkerDictionary dictionary(params.dictionary);
  for (const int id : whitelist) {
    if (id >= 0 && id < dictionary.count()) continue;
    throw ConfigError("marker whitelist: " + params.dictionary + " has no id " + std::to_string(id) +
                      ", only 0 to " + std::to_string(dictionary.count() - 1));
  }
  impl_->params = params;
  impl_->whitelist = whitelist;
  impl_->dictionary = cv::aruco::getPredefinedDictionary(dictionary.index());
  impl_->cells = dictionary.cells();
}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;
MarkerDetector& MarkerDetector::operator=(MarkerDetector&&) noexcept = default;

MarkerFindings MarkerDetector::detect(const cv::Mat& image) const {
  MarkerFindings findings;
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    findings.fault = image.empty() ? "the image is empty" : "the image is neither 8-bit grey nor 8-bit BGR";
    return findings;
  }
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  std::vector<Quad> quads;
  std::vector<int> ids;
  cv::Mat light;
  cv::aruco::detectMarkers(grey, impl_->dictionary, quads, ids, impl_->settingsFor(grey));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!impl_->isListed(ids[i])) {
      findings.unlisted_ids.push_back(ids[i]);
      continue;
    }
    MarkerCorners marker = toCorners(ids[i], quads[i]);
    if (light.empty()) light = marker_detail::linearLight(grey);
    marker.has_edges = marker_detail::fitEdges(light, impl_->cells, marker.pixels);
    marker.is_clipped = marker_detail::isClipped(light, impl_->cells, marker.pixels);
    findings.markers.push_back(marker);
  }
  std::stable_sort(findings.markers.begin(), findings.markers.end(),
                   [](const MarkerCorners& a, const MarkerCorners& b) { return a.id < b.id; });
  return findings;
}

}  // namespace frugal_nav
