#pragma once

#include <memory>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// Worlds in the format of the BARN challenge, driven by its rules.
std::unique_ptr<Suite> makeBarnSuite();

}  // namespace frugal_nav::eval
