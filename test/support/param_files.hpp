#pragma once

#include <set>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav::test {

/// A node's file in config documents every parameter and changes none: whoever reads it knows the defaults.
template <class Params>
void expectDefaults(const std::string& name) {
  const std::string file = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/" + name;
  EXPECT_EQ(toYaml(loadParamFile<Params>(file)), toYaml(Params{}));
  std::set<std::string> wanted;
  for (const FieldDescription& field : describe(Params{})) wanted.insert(field.name);
  std::set<std::string> found;
  for (const auto& [key, value] : readParamFile(file)) found.insert(key);
  EXPECT_EQ(found, wanted);
}

}  // namespace frugal_nav::test
