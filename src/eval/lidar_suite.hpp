#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Driving with the LIDAR through random rooms and corridors.
std::unique_ptr<Suite> makeLidarSuite();

}  // namespace frugal_nav::eval
