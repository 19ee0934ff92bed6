#include <fstream>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/planning_params.hpp>

namespace frugal_nav {
namespace {

/// The file holds every parameter of the struct and no other, each with its comment.
template <class Params>
void expectComplete(const std::string& name) {
  const std::string path = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/" + name;
  ASSERT_NO_THROW(loadParamFile<Params>(path));
  const ParamTree tree = readParamFile(path);
  const std::vector<FieldDescription> fields = describe(Params{});
  EXPECT_EQ(tree.size(), fields.size());
  for (const FieldDescription& field : fields) EXPECT_TRUE(tree.count(field.name)) << field.name;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const bool opens_group = !line.empty() && line.back() == ':';
    EXPECT_TRUE(opens_group || line.find("# ") != std::string::npos) << line;
  }
}

TEST(PlannerConfig, HoldsEveryParameter) { expectComplete<PlannerNodeParams>("planner.yaml"); }

TEST(CameraPlannerConfig, HoldsEveryParameter) {
  expectComplete<CameraPlannerNodeParams>("camera_planner.yaml");
}

TEST(LidarAvoidanceConfig, HoldsEveryParameter) {
  expectComplete<LidarAvoidanceNodeParams>("lidar_avoidance.yaml");
}

}  // namespace
}  // namespace frugal_nav
