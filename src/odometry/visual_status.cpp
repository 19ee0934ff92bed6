#include <frugal_nav/odometry/visual_status.hpp>

namespace frugal_nav {

const char* text(VisualState state) {
  switch (state) {
    case VisualState::kInitializing:
      return "initializing";
    case VisualState::kTracking:
      return "tracking";
    case VisualState::kRotating:
      return "rotating";
    case VisualState::kLost:
      return "lost";
  }
  return "";
}

const char* text(VisualReason reason) {
  switch (reason) {
    case VisualReason::kNone:
      return "";
    case VisualReason::kFirstImage:
      return "first image";
    case VisualReason::kBadImage:
      return "the image is empty or of a type that is no picture";
    case VisualReason::kDark:
      return "the image is dark";
    case VisualReason::kSaturated:
      return "the image is saturated";
    case VisualReason::kNoContrast:
      return "the image shows an even surface";
    case VisualReason::kBlurred:
      return "the image is blurred";
    case VisualReason::kFewFeatures:
      return "too few features";
    case VisualReason::kNoParallax:
      return "no parallax: the camera has hardly moved";
    case VisualReason::kShortBaseline:
      return "the wheels have not moved far enough for the scale";
    case VisualReason::kRansacFailed:
      return "no motion explains enough features";
    case VisualReason::kFewMapPoints:
      return "too little of the map is in view";
    case VisualReason::kWheelsDisagree:
      return "wheels and images disagree";
    case VisualReason::kNoWheels:
      return "no wheel odometry: the scale is unknown";
    case VisualReason::kTimeJumpedBack:
      return "time jumped back";
  }
  return "";
}

}  // namespace frugal_nav
