#pragma once

#include <cstdint>
#include <string>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// Whose command the base follows.
enum class Mode : std::uint8_t { kIdle, kLidar, kCamera, kAligning, kRecovering, kManual };

/// How far the mission is.
enum class MissionPhase : std::uint8_t { kIdle, kDriving, kRecovering, kReached, kAborted, kCancelled };

/// What the robot is doing now: what mission/ decides and control/ obeys. The message MissionState carries
/// it.
struct MissionStatus {
  Stamp stamp{};  ///< of the odometry it rests on
  Mode mode = Mode::kIdle;
  MissionPhase phase = MissionPhase::kIdle;
  std::string reason;
  std::uint32_t goal_number = 0;
};

}  // namespace frugal_nav
