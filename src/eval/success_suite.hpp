#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// The suite "success": the camera system in the paper's trials.
std::unique_ptr<Suite> makeSuccessSuite();

}  // namespace frugal_nav::eval
