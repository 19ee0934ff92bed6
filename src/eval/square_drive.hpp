#pragma once

#include <cstdint>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/drive_body.hpp>

namespace frugal_nav::eval {

/// How a square is driven.
struct SquareParams {
  double side_m = 4.0;
  double speed_mps = 0.3;
  double turn_radps = 0.8;
  bool clockwise = false;
};

/// A square driven on an empty floor, in the frame of its start.
struct SquareDrive {
  Pose2 truth;                   ///< where the robot ended
  std::vector<Pose2> estimates;  ///< where each odometry says it ended
  double length_m = 0.0;         ///< true length of the way
};

/// Drives a square by the first odometry's word; all of them read the same ticks.
/// Throws std::runtime_error when the driver does not finish.
SquareDrive driveSquare(const RobotModel& robot, const SquareParams& square, const sim::DriveBodyParams& body,
                        std::uint64_t seed, const std::vector<WheelOdometryParams>& odometries);

}  // namespace frugal_nav::eval
