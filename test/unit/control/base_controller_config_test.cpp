#include <gtest/gtest.h>
#include <support/param_files.hpp>

#include <frugal_nav/ros/base_controller_params.hpp>

namespace frugal_nav {
namespace {

TEST(BaseControllerNodeParams, TheFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<BaseControllerNodeParams>("base_controller.yaml");
}

}  // namespace
}  // namespace frugal_nav
