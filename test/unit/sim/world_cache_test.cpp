#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <support/temp_folder.hpp>
#include <unit/sim/world_files.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/scene_archive.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;
using frugal_nav::test::TempFolder;

/// A world with something of everything that a scene holds.
std::string writeWorld(const TempFolder& folder, double box_size = 1.0) {
  folder.write("models/tri/tri.dae", test::daeText("Z_UP", "tri.png"));
  folder.write("models/tri/tri.png", test::pngBytes(4, 4, 1, 2, 3));
  const std::string box = "<box><size>" + std::to_string(box_size) + " 1 1</size></box>";
  return folder.write(
      "test.world",
      test::worldText(
          test::modelText("box", test::visualText(box) + test::collisionText(box), "1 2 3 0.1 0.2 0.3") +
          test::modelText("tri", test::visualText(test::meshText("model://tri/tri.dae"))) +
          "<light name='sun' type='directional'><direction>0 0.1 -1</direction></light>"
          "<actor name='clerk'><pose>3 2 0 0 0 1</pose><skin><filename>stand.dae</filename></skin></actor>"
          "<plugin name='weather' filename='libweather.so'/>"));
}

std::vector<fs::path> cacheFiles(const TempFolder& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder.path("cache"))) files.push_back(entry.path());
  return files;
}

LoadedWorld load(const TempFolder& folder) {
  return loadWorldCached(folder.path("test.world"), {}, folder.path("cache"));
}

TEST(SceneArchive, GivesBackEveryField) {
  const TempFolder folder;
  const LoadedWorld world = loadWorld(writeWorld(folder), {});
  ASSERT_FALSE(world.scene.textures.empty());
  ASSERT_FALSE(world.scene.people.empty());
  ASSERT_FALSE(world.warnings.empty());
  const std::string bytes = toBytes(world);
  const auto read = fromBytes(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(toBytes(*read), bytes);
  EXPECT_EQ(read->warnings, world.warnings);
  EXPECT_EQ(read->scene.textures[0].rgb, world.scene.textures[0].rgb);
  EXPECT_EQ(read->scene.people[0].appearance, world.scene.people[0].appearance);
  EXPECT_TRUE(read->scene.models[0].world_from_model.isApprox(world.scene.models[0].world_from_model, 0.0));
  EXPECT_EQ(read->scene.lights[0].direction, world.scene.lights[0].direction);
  EXPECT_EQ(read->scene.meshes[0].vertices, world.scene.meshes[0].vertices);
}

TEST(SceneArchive, RefusesEveryShorterAndLongerText) {
  const TempFolder folder;
  const std::string bytes = toBytes(loadWorld(writeWorld(folder), {}));
  EXPECT_FALSE(fromBytes(bytes + "x"));
  EXPECT_FALSE(fromBytes(""));
  for (std::size_t size = 0; size < bytes.size(); size += 97) EXPECT_FALSE(fromBytes(bytes.substr(0, size)));
}

TEST(WorldCache, SecondLoadEqualsTheFirst) {
  const TempFolder folder;
  writeWorld(folder);
  const LoadedWorld first = load(folder);
  ASSERT_EQ(cacheFiles(folder).size(), 1U);
  const LoadedWorld second = load(folder);
  EXPECT_EQ(toBytes(second), toBytes(first));
  EXPECT_EQ(toBytes(second), toBytes(loadWorld(folder.path("test.world"), {})));
}

TEST(WorldCache, FollowsChangesOfTheWorldAndOfItsFiles) {
  const TempFolder folder;
  writeWorld(folder);
  EXPECT_DOUBLE_EQ(load(folder).scene.models[0].collisions[0].size_m.x(), 1.0);
  writeWorld(folder, 2.5);
  EXPECT_DOUBLE_EQ(load(folder).scene.models[0].collisions[0].size_m.x(), 2.5);
  EXPECT_EQ(cacheFiles(folder).size(), 1U);  // the old one is replaced
  const std::string image = folder.write("models/tri/tri.png", test::pngBytes(4, 4, 9, 9, 9));
  fs::last_write_time(image, fs::last_write_time(image) + std::chrono::seconds(2));
  EXPECT_EQ(load(folder).scene.textures.at(0).rgb.at(0), 9);
  fs::remove(image);
  EXPECT_TRUE(test::mentions(load(folder).warnings, {"tri.png"}));
}

TEST(WorldCache, SurvivesBrokenFiles) {
  const TempFolder folder;
  writeWorld(folder);
  const std::string good = toBytes(load(folder));
  const fs::path cache = cacheFiles(folder).at(0);
  std::ifstream stream(cache, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  std::string flipped = bytes;
  flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 0x10);
  std::string older = bytes;
  older[8] = static_cast<char>(older[8] + 1);  // the version stands behind eight bytes of magic
  for (const std::string& broken : {std::string(), std::string("x"), bytes.substr(0, 40),
                                    bytes.substr(0, bytes.size() - 1), bytes + "x", flipped, older}) {
    std::ofstream(cache, std::ios::binary) << broken;
    EXPECT_EQ(toBytes(load(folder)), good);
    EXPECT_EQ(fs::file_size(cache), bytes.size());  // and it is made again
  }
  EXPECT_EQ(cacheFiles(folder).size(), 1U);  // no temporary file stays
}

TEST(WorldCache, IsUsed) {
  const TempFolder folder;
  writeWorld(folder);
  load(folder);
  const auto made = fs::last_write_time(cacheFiles(folder).at(0));
  load(folder);
  EXPECT_EQ(fs::last_write_time(cacheFiles(folder).at(0)), made);
}

TEST(WorldCache, DoesNotKeepWorldsWithMissingFiles) {
  const TempFolder folder;
  folder.write("test.world", test::worldText("<include><uri>model://ghost</uri></include>"));
  EXPECT_FALSE(load(folder).is_complete);
  EXPECT_FALSE(fs::exists(folder.path("cache")));
}

TEST(WorldCache, WorksWithoutAFolderToWriteTo) {
  const TempFolder folder;
  const std::string world = writeWorld(folder);
  EXPECT_EQ(loadWorldCached(world, {}, "").scene.models.size(), 2U);
  const std::string file = folder.write("file", "");
  EXPECT_EQ(loadWorldCached(world, {}, file + "/below").scene.models.size(), 2U);
  EXPECT_THROW(loadWorldCached(folder.path("none.world"), {}, folder.path("cache")), ConfigError);
  EXPECT_THROW(loadWorldCached(folder.path(), {}, folder.path("cache")), ConfigError);
}

TEST(WorldCache, DefaultFolderFollowsTheXdgVariable) {
  const char* const old_value = std::getenv("XDG_CACHE_HOME");
  const std::string saved = old_value == nullptr ? "" : old_value;
  setenv("XDG_CACHE_HOME", "/somewhere", 1);
  EXPECT_EQ(defaultCacheFolder(), "/somewhere/frugal_nav");
  unsetenv("XDG_CACHE_HOME");
  if (const char* home = std::getenv("HOME")) {
    EXPECT_EQ(defaultCacheFolder(), std::string(home) + "/.cache/frugal_nav");
  }
  if (old_value != nullptr) setenv("XDG_CACHE_HOME", saved.c_str(), 1);
}

TEST(WorldCache, LoadsWorldsInTheFormatOfBarn) {
  const char* shared = std::getenv("FRUGAL_NAV_SHARED");
  const std::string archive =
      (shared != nullptr ? std::string(shared) : std::string(FRUGAL_NAV_SOURCE_DIR) + "/../shared") +
      "/barn/worlds.tar.xz";
  if (!fs::exists(archive))
    GTEST_SKIP() << "no " << archive << ": set FRUGAL_NAV_SHARED to the folder of shared data";
  const TempFolder folder;
  const std::string command = "tar -xJf '" + archive + "' -C '" + folder.path() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  int loaded = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.path().extension() != ".world" || loaded == 3)
      continue;  // one takes a second: three show the format
    ++loaded;
    const LoadedWorld world = loadWorldCached(entry.path().string(), {}, folder.path("cache"));
    EXPECT_TRUE(world.warnings.empty()) << entry.path() << ": " << world.warnings.front();
    EXPECT_GT(world.scene.models.size(), 100U);
    EXPECT_LT(world.scene.meshes.size(), 10U);  // the cylinders share theirs
    const LoadedWorld cached = loadWorldCached(entry.path().string(), {}, folder.path("cache"));
    EXPECT_EQ(toBytes(cached), toBytes(world));
  }
  EXPECT_EQ(loaded, 3);
}

}  // namespace
}  // namespace frugal_nav::sim
