#include "visual_flow.hpp"
#include "visual_matching.hpp"

#include <frugal_nav/odometry/visual_front_end.hpp>

namespace frugal_nav {

std::unique_ptr<VisualFrontEnd> makeVisualFrontEnd(const VisualFeatureParams& params) {
  if (params.method == "matching") return std::make_unique<VisualMatching>(params);
  return std::make_unique<VisualFlow>(params);
}

}  // namespace frugal_nav
