#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// A detector and the range from its boxes, on scenes that no network has seen.
std::unique_ptr<Suite> makeDetectorSuite();

}  // namespace frugal_nav::eval
