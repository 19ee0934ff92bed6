#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Depth of a thing 0.6 to 2.4 m ahead, or of all pixels of a real recording.
std::unique_ptr<Suite> makeDepthSuite();

}  // namespace frugal_nav::eval
