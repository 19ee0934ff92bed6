#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Localization by markers in simulated halls, and the filter on recorded robots that saw landmarks.
std::unique_ptr<Suite> makeMarkersSuite();

}  // namespace frugal_nav::eval
