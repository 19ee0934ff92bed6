#pragma once

#include <limits>

namespace frugal_nav {

/// What visual odometry is doing.
enum class VisualState {
  kInitializing,  ///< waits for a baseline to make a map; the pose follows the wheels
  kTracking,      ///< the pose comes from the map
  kRotating,      ///< turns where no map is in view: direction from the images, position from the wheels
  kLost,          ///< the images are of no use; the pose follows the wheels
};

/// Why it does so.
enum class VisualReason {
  kNone,
  kFirstImage,
  kBadImage,        ///< empty, or of a type that is no picture
  kDark,            ///< nothing to be seen for want of light
  kSaturated,       ///< nothing to be seen for too much light
  kNoContrast,      ///< an even surface
  kBlurred,         ///< features were lost in motion blur
  kFewFeatures,     ///< too few features could be followed
  kNoParallax,      ///< no map can be made without moving
  kShortBaseline,   ///< the wheels have not moved far enough to give the scale
  kRansacFailed,    ///< no motion explains enough features
  kFewMapPoints,    ///< too little of the map is in view
  kWheelsDisagree,  ///< wheels and images tell different motions
  kNoWheels,        ///< no wheel odometry: the scale is unknown
  kTimeJumpedBack,  ///< a stamp older than the last: everything was forgotten
};

/// Words for messages and logs.
const char* text(VisualState state);
const char* text(VisualReason reason);

/// How visual odometry fares.
struct VisualStatus {
  VisualState state = VisualState::kInitializing;
  VisualReason reason = VisualReason::kFirstImage;
  int features = 0;  ///< followed in this image
  int inliers = 0;   ///< map points (initializing, rotating: features) that fit the pose
  /// Wheel distance over map distance, the median of the last baselines; NaN unknown. The map is metric, so
  /// that it is near one.
  double scale = std::numeric_limits<double>::quiet_NaN();
  double scale_sigma = std::numeric_limits<double>::quiet_NaN();  ///< standard deviation of the scale
};

}  // namespace frugal_nav
