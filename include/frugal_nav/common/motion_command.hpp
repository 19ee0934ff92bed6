#pragma once

#include <cstdint>
#include <string>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// What a local planner wants of the base: what planning/ gives, control/ executes and mission/ watches.
/// The message LocalCommand carries it; the core has a name of its own because both share the namespace.
struct MotionCommand {
  enum class Status {
    kIdle,     ///< no goal
    kDriving,  ///< the command holds; where it holds nothing, it stands while something that moves passes
    kTurning,  ///< no free direction: turning on the spot toward the larger clearance
    kBlocked,  ///< no way past the obstacles, even at the body's own width
    kStopped,  ///< an input is missing, stale or unusable; `reason` says which
  };
  enum class Holds { kNothing, kTarget, kVelocity };

  Stamp stamp{};  ///< of the scan it rests on
  Status status = Status::kIdle;
  std::string reason;
  std::uint32_t goal_number = 0;  ///< of the mission's status: the goal it leads to
  Holds holds = Holds::kNothing;
  Pose2 odom_from_target;          ///< for kTarget; only its position is driven to
  Twist2 velocity;                 ///< for kVelocity
  double clear_bearing_rad = 0.0;  ///< direction of the larger clearance, in base_link
};

}  // namespace frugal_nav
