#pragma once

#include "camera_drive.hpp"

#include <memory>

#include <frugal_nav/eval/camera_stack.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {

/// Drives blindly straight at a goal in the frame of the start: what the camera has to beat.
std::unique_ptr<CameraDriver> makeStraightDriver(const CameraStackParams& params, const RobotModel& robot,
                                                 double speed_mps, const Pose2& odom_from_goal);

/// The classes of the node graph, with the latency of one period of the pipeline.
std::unique_ptr<CameraDriver> makeStackDriver(const CameraStackParams& params, const RobotModel& robot,
                                              double speed_mps, double rate_hz,
                                              const sim::Simulator& simulator);

}  // namespace frugal_nav::eval
