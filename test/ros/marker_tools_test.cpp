// The programs around the markers as people run them: exit codes, and what they say of wrong arguments.

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/ros_test.hpp>
#include <support/temp_folder.hpp>

namespace frugal_nav {
namespace {

using test::ProgramResult;
using test::runProgram;
using testing::AllOf;
using testing::HasSubstr;

const std::string kMap = std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/marker_wall.yaml";

TEST(CheckMarkerMap, TellsSoundSuspiciousAndFaultyMapsApart) {
  const ProgramResult sound = runProgram("check_marker_map", kMap);
  EXPECT_EQ(sound.exit_code, 0) << sound.output;
  EXPECT_THAT(sound.output, AllOf(HasSubstr("id 0:"), HasSubstr("ok")));
  const ProgramResult low = runProgram("check_marker_map", kMap + " --max-height 0.1");
  EXPECT_EQ(low.exit_code, 1);
  EXPECT_THAT(low.output, HasSubstr("SUSPICIOUS marker 0"));
  const test::TempFolder folder;
  const std::string marker = "  - {id: 3, position: [4.0, 0.6, 0.5], rpy: [1.5707963, 0.0, -1.5707963]}\n";
  const std::string twice = folder.write("twice.yaml", "size_m: 0.2\nmarkers:\n" + marker + marker);
  const ProgramResult faulty = runProgram("check_marker_map", twice);
  EXPECT_EQ(faulty.exit_code, 1);
  EXPECT_THAT(faulty.output, AllOf(HasSubstr("FAULT"), HasSubstr("twice")));
}

TEST(CheckMarkerMap, RefusesWrongArguments) {
  for (const std::string& arguments :
       {std::string(), std::string("--max-height 2.0"), kMap + " --max-height", kMap + " --max-height nan",
        kMap + " --max-height high", kMap + " --tallest 2", kMap + " " + kMap}) {
    const ProgramResult result = runProgram("check_marker_map", arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.output, HasSubstr("usage")) << arguments;
  }
  EXPECT_EQ(runProgram("check_marker_map", "--help").exit_code, 0);
}

TEST(PrintMarkers, MakesASheetForEachMarker) {
  const test::TempFolder folder;
  const std::string out = folder.path("sheets");
  const ProgramResult by_id = runProgram("print_markers", "--ids 0-2,7 --size 0.15 --out " + out);
  EXPECT_EQ(by_id.exit_code, 0) << by_id.output;
  for (const char* name : {"marker_000.svg", "marker_002.svg", "marker_007.svg"})
    EXPECT_GT(std::filesystem::file_size(out + "/" + name), 500U) << name;
  EXPECT_FALSE(std::filesystem::exists(out + "/marker_003.svg"));
  const std::string hung = folder.path("hung");
  const ProgramResult by_map = runProgram("print_markers", "--map " + kMap + " --paper a3 --out " + hung);
  EXPECT_EQ(by_map.exit_code, 0) << by_map.output;
  EXPECT_TRUE(std::filesystem::exists(hung + "/marker_003.svg"));
}

TEST(PrintMarkers, RefusesWrongArguments) {
  for (const std::string& arguments :
       {std::string("--ids 0-3"), std::string("--ids 3-0 --size 0.1"), std::string("--ids x --size 0.1"),
        std::string("--ids 1 --size 0.2 --paper a9"), std::string("--ids 1 --size nan"),
        std::string("--ids 99 --size 0.1"), std::string("--ids 1 --size 0.1 --dictionary DICT_9X9"),
        "--map " + kMap + " --ids 1", std::string("--map /nowhere/map.yaml"), std::string("--size")}) {
    const ProgramResult result = runProgram("print_markers", arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments << "\n" << result.output;
    EXPECT_THAT(result.output, HasSubstr("print_markers: ")) << arguments;
  }
  EXPECT_EQ(runProgram("print_markers").exit_code, 2);
  EXPECT_EQ(runProgram("print_markers", "--help").exit_code, 0);
}

TEST(ImportPoseLog, MakesATableOrABag) {
  const test::TempFolder folder;
  const std::string log = folder.write("drive.log", "x0.52y1.34t0.98i7x0.50y1.31t0.97i9 #x0.6y1.4t1.0i7 #");
  const ProgramResult table = runProgram("import_pose_log", log);
  EXPECT_EQ(table.exit_code, 0) << table.output;
  EXPECT_THAT(table.output, AllOf(HasSubstr("0,0.5200,1.3400,0.98000,7"), HasSubstr("1,0.6000,1.4000"),
                                  HasSubstr("3 poses in 2 records")));
  const std::string bag = folder.path("drive.bag");
  EXPECT_EQ(runProgram("import_pose_log", log + " --bag " + bag + " --rate 5").exit_code, 0);
  EXPECT_GT(std::filesystem::file_size(bag), 1000U);
}

TEST(ImportPoseLog, RefusesWrongArguments) {
  const test::TempFolder folder;
  const std::string log = folder.write("drive.log", "x0.52y1.34t0.98i7 #");
  for (const std::string& arguments :
       {std::string("/nowhere/drive.log"), log + " --rate 0", log + " --sigma 0.1", log + " --speed 9",
        log + " " + log, log + " --bag /nowhere/drive.bag", std::string("--bag only.bag")}) {
    const ProgramResult result = runProgram("import_pose_log", arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments << "\n" << result.output;
    EXPECT_THAT(result.output, HasSubstr("import_pose_log: ")) << arguments;
  }
  EXPECT_EQ(runProgram("import_pose_log").exit_code, 2);
  EXPECT_EQ(runProgram("import_pose_log", "--help").exit_code, 0);
  const std::string nothing = folder.write("noise.log", "hello # world #");
  EXPECT_EQ(runProgram("import_pose_log", nothing).exit_code, 1);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
