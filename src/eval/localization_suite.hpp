#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Wheel odometry and both kinds of visual odometry over the same drives, in each light.
std::unique_ptr<Suite> makeLocalizationSuite();

}  // namespace frugal_nav::eval
