#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/detection.hpp>
#include <frugal_nav/perception/letterbox.hpp>
#include <frugal_nav/perception/network.hpp>

namespace frugal_nav {

/// The params themselves once they are found valid: for use where members are initialised.
template <class Params>
const Params& validated(const Params& params, const std::string& where) {
  validate(params, where);
  return params;
}

/// A file name as given when absolute or empty, else within the folder.
inline std::string inFolder(const std::string& folder, const std::string& file) {
  return file.empty() || folder.empty() || file.front() == '/' ? file : folder + "/" + file;
}

inline std::vector<cv::Mat> valuesOf(const std::vector<NetworkOutput>& outputs) {
  std::vector<cv::Mat> values;
  for (const NetworkOutput& output : outputs) values.push_back(output.value);
  return values;
}

/// Boxes of the network's input, in the image: cut at its edges; what lies outside is left out.
inline std::vector<Detection> intoImage(std::vector<Detection> boxes, const Letterbox& letterbox,
                                        const cv::Size& image) {
  const cv::Rect2d frame(0.0, 0.0, image.width, image.height);
  std::vector<Detection> inside;
  for (Detection& box : boxes) {
    box.box = letterbox.toImage(box.box) & frame;
    if (box.box.width > 0.0 && box.box.height > 0.0) inside.push_back(std::move(box));
  }
  return inside;
}

}  // namespace frugal_nav
