#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace frugal_nav {

/// One of OpenCV's predefined sets of square markers.
class MarkerDictionary {
 public:
  /// By OpenCV's name for it, such as DICT_4X4_50. Throws ConfigError, with all names, on another.
  explicit MarkerDictionary(const std::string& name);

  /// Every name there is.
  static const std::vector<std::string>& names();

  const std::string& name() const { return name_; }
  int index() const { return index_; }           ///< OpenCV's number for it
  int count() const { return count_; }           ///< ids are 0 to count - 1
  int cells() const { return code_cells_ + 2; }  ///< along a side, with the black border

  /// A marker upright, one pixel a cell with its black border: 0 or 255. The id must be below count().
  cv::Mat cellsOf(int id) const;

 private:
  std::string name_;
  int index_;
  int count_;
  int code_cells_;
};

}  // namespace frugal_nav
