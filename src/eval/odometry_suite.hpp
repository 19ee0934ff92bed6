#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Wheel odometry on squares, as UMBmark drives them.
std::unique_ptr<Suite> makeOdometrySuite();

}  // namespace frugal_nav::eval
