#pragma once

#include "camera_drive.hpp"

#include <string>

namespace frugal_nav::eval {

/// Writes a picture of a trial: the floor plan with the true way (green), the way the robot believed it drove
/// (blue), its last path (magenta), what it remembered (red), walker (orange), person and stand-off point;
/// beside it the last image with what was seen. Throws ConfigError when it cannot be written.
void writeDrivePicture(const std::string& path, const CameraLayout& layout, const CameraDriveRecord& record,
                       const CameraDriver& driver, const std::string& title);

}  // namespace frugal_nav::eval
