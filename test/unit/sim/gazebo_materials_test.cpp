#include <gtest/gtest.h>

#include <frugal_nav/sim/gazebo_materials.hpp>

namespace frugal_nav::sim {
namespace {

TEST(GazeboMaterials, KnowsTheUsualNames) {
  ASSERT_TRUE(gazeboMaterial("Gazebo/Grey"));
  EXPECT_TRUE(gazeboMaterial("Gazebo/Grey")->albedo.isApprox(Eigen::Vector3f(0.7F, 0.7F, 0.7F)));
  EXPECT_TRUE(gazeboMaterial("Gazebo/RedTransparent")->albedo.isApprox(Eigen::Vector3f(1.0F, 0.0F, 0.0F)));
  EXPECT_TRUE(gazeboMaterial("Gazebo/Red")->emission.isZero());
  EXPECT_FALSE(gazeboMaterial("Gazebo/Plaid"));
  EXPECT_FALSE(gazeboMaterial("Red"));
}

TEST(GazeboMaterials, GlowIsLight) {
  EXPECT_TRUE(gazeboMaterial("Gazebo/GreenGlow")->emission.isApprox(Eigen::Vector3f(0.0F, 1.0F, 0.0F)));
}

TEST(GazeboMaterials, ReadsTheNamedMaterialOfAScript) {
  const std::string script = R"(
material Shop/Door
{
  technique { pass { diffuse 1 0 0 1 } }
}
// material Shop/Shelf is below
material Shop/Shelf
{
  technique
  {
    pass
    {
      diffuse 0.1 0.2 0.3 1
      texture_unit
      {
        texture shelf.png
      }
    }
  }
}
material Shop/Floor
{
  technique
  {
    pass
    {
      diffuse 0 0 0 1
      texture_unit
      {
        texture floor.png
      }
    }
  }
}
)";
  const auto shelf = parseMaterialScript(script, "Shop/Shelf");
  ASSERT_TRUE(shelf);
  EXPECT_TRUE(shelf->material.albedo.isApprox(Eigen::Vector3f(0.1F, 0.2F, 0.3F)));
  EXPECT_EQ(shelf->texture_name, "shelf.png");
  EXPECT_FALSE(parseMaterialScript(script, "Shop/Window"));
}

TEST(GazeboMaterials, ReadsAttributesInOneLine) {
  const auto door = parseMaterialScript("material A { technique { pass { diffuse 1 0 0 1 } } }", "A");
  ASSERT_TRUE(door);
  EXPECT_TRUE(door->material.albedo.isApprox(Eigen::Vector3f(1.0F, 0.0F, 0.0F)));
}

}  // namespace
}  // namespace frugal_nav::sim
