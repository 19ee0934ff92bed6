#include <algorithm>

#include <opencv2/aruco.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>

namespace frugal_nav {

const std::vector<std::string>& MarkerDictionary::names() {
  // In the order of OpenCV's enumeration: a name's place is its number.
  static const std::vector<std::string> kNames = {
      "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
      "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
      "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
      "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
      "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
      "DICT_APRILTAG_36h11"};
  return kNames;
}

MarkerDictionary::MarkerDictionary(const std::string& name) : name_(name) {
  static_assert(cv::aruco::DICT_4X4_50 == 0 && cv::aruco::DICT_ARUCO_ORIGINAL == 16 &&
                    cv::aruco::DICT_APRILTAG_36h11 == 20,
                "the names are in another order than OpenCV's numbers");
  const auto found = std::find(names().begin(), names().end(), name);
  if (found == names().end()) {
    std::string message = "unknown marker dictionary \"" + name + "\"; known are";
    for (const std::string& known : names()) message += " " + known;
    throw ConfigError(message);
  }
  index_ = static_cast<int>(found - names().begin());
  const auto dictionary = cv::aruco::getPredefinedDictionary(index_);
  count_ = dictionary->bytesList.rows;
  code_cells_ = dictionary->markerSize;
}

cv::Mat MarkerDictionary::cellsOf(int id) const {
  cv::Mat image;
  cv::aruco::getPredefinedDictionary(index_)->drawMarker(id, cells(), image, 1);
  return image;
}

}  // namespace frugal_nav
