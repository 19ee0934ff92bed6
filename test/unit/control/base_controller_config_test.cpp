#include <set>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/base_controller_params.hpp>

namespace frugal_nav {
namespace {

const std::string kFile = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/base_controller.yaml";

// The file documents every parameter and changes none: whoever reads it knows the defaults.
TEST(BaseControllerNodeParams, TheFileHoldsEveryParameterWithItsDefault) {
  const BaseControllerNodeParams loaded = loadParamFile<BaseControllerNodeParams>(kFile);
  EXPECT_EQ(toYaml(loaded), toYaml(BaseControllerNodeParams{}));
  std::set<std::string> wanted;
  for (const FieldDescription& field : describe(BaseControllerNodeParams{})) wanted.insert(field.name);
  std::set<std::string> found;
  for (const auto& [key, value] : readParamFile(kFile)) found.insert(key);
  EXPECT_EQ(found, wanted);
}

}  // namespace
}  // namespace frugal_nav
