#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// The suite "pipeline": time a frame by stage.
std::unique_ptr<Suite> makePipelineSuite();

}  // namespace frugal_nav::eval
