#include <cstdlib>

#include <gtest/gtest.h>
#include <support/temp_folder.hpp>

#include <frugal_nav/sim/resource_path.hpp>

namespace frugal_nav::sim {
namespace {

TEST(ResourcePath, FindsModelsInTheOrderOfTheFolders) {
  const frugal_nav::test::TempFolder folder;
  folder.write("first/chair/model.sdf", "");
  folder.write("second/chair/model.sdf", "");
  folder.write("second/table/model.sdf", "");
  const ResourcePath resources({folder.path("first"), folder.path("second")}, {});
  EXPECT_EQ(resources.find("model://chair/model.sdf", "").value_or(""), folder.path("first/chair/model.sdf"));
  EXPECT_EQ(resources.find("model://table", "").value_or(""), folder.path("second/table"));
  EXPECT_FALSE(resources.find("model://sofa", ""));
}

TEST(ResourcePath, FindsPackagesInFoldersAndAsFolders) {
  const frugal_nav::test::TempFolder folder;
  folder.write("src/rooms/meshes/wall.dae", "");
  folder.write("checkout/package.xml", "<package><name>houses</name></package>");
  folder.write("checkout/roof.dae", "");
  const ResourcePath resources({}, {folder.path("src"), folder.path("checkout")});
  EXPECT_EQ(resources.find("package://rooms/meshes/wall.dae", "").value_or(""),
            folder.path("src/rooms/meshes/wall.dae"));
  EXPECT_EQ(resources.find("package://houses/roof.dae", "").value_or(""), folder.path("checkout/roof.dae"));
  EXPECT_FALSE(resources.find("package://castles/roof.dae", ""));
}

TEST(ResourcePath, FindsPlainFilesAndRefusesOtherSchemes) {
  const frugal_nav::test::TempFolder folder;
  const std::string file = folder.write("meshes/a.stl", "");
  const ResourcePath resources;
  EXPECT_EQ(resources.find("file://" + file, "").value_or(""), file);
  EXPECT_EQ(resources.find(file, "/elsewhere").value_or(""), file);
  EXPECT_EQ(resources.find("meshes/a.stl", folder.path()).value_or(""), file);
  EXPECT_FALSE(resources.find("https://example.org/meshes/a.stl", folder.path()));
  EXPECT_FALSE(resources.find("", folder.path()));
}

TEST(ResourcePath, LooksBesideTheWorldLast) {
  const frugal_nav::test::TempFolder folder;
  folder.write("models/chair/model.sdf", "");
  folder.write("worlds/models/table/model.sdf", "");
  const ResourcePath resources = ResourcePath({"/given"}, {}).withWorld(folder.path("worlds/room.world"));
  EXPECT_EQ(resources.modelFolders().front(), "/given");
  EXPECT_TRUE(resources.find("model://chair", ""));
  EXPECT_TRUE(resources.find("model://table", ""));
}

TEST(ResourcePath, ReadsTheEnvironment) {
  const char* const old_value = std::getenv("GAZEBO_MODEL_PATH");
  const std::string saved = old_value == nullptr ? "" : old_value;
  setenv("GAZEBO_MODEL_PATH", "/a:/b::", 1);
  EXPECT_EQ(ResourcePath::fromEnvironment().modelFolders(), (std::vector<std::string>{"/a", "/b"}));
  unsetenv("GAZEBO_MODEL_PATH");
  EXPECT_TRUE(ResourcePath::fromEnvironment().modelFolders().empty());
  if (old_value != nullptr) setenv("GAZEBO_MODEL_PATH", saved.c_str(), 1);
}

TEST(ResourcePath, FindsTexturesByBaseName) {
  const frugal_nav::test::TempFolder folder;
  const std::string image = folder.write("chair/materials/textures/oak.png", "");
  folder.write("chair/meshes/chair.dae", "");
  const ResourcePath resources;
  const std::string mesh_folder = folder.path("chair/meshes");
  for (const char* name :
       {"oak.png", "../../materials/textures/oak.png", "C:\\art\\oak.png", "/elsewhere/art/oak.png"}) {
    EXPECT_EQ(findTexture(name, mesh_folder, resources).value_or(""), image) << name;
  }
  EXPECT_FALSE(findTexture("ash.png", mesh_folder, resources));
}

}  // namespace
}  // namespace frugal_nav::sim
