#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav {
namespace {

struct InnerParams {
  double sigma_m = 0.01;
  std::string frame = "odom";

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("sigma_m", sigma_m, Field{"m", "noise", 0.0, 1.0});
    visit("frame", frame, Field{"", "frame: of the output # not a comment"});
  }
};

struct OuterParams {
  double whole = 2.0;
  double fraction = 0.1;
  double tiny = 1e-7;
  int count = 5;
  bool enabled = true;
  std::string name = "yes";  // looks like a truth value
  std::string number = "12";
  std::vector<double> list{1.0, 2.5};
  std::vector<std::string> texts{"1", "b c"};
  InnerParams inner;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("whole", whole, Field{});
    visit("fraction", fraction, Field{});
    visit("tiny", tiny, Field{});
    visit("count", count, Field{});
    visit("enabled", enabled, Field{});
    visit("name", name, Field{});
    visit("number", number, Field{});
    visit("list", list, Field{});
    visit("texts", texts, Field{});
    visit("inner", inner);
  }
};

std::string refusal(const std::string& yaml) {
  try {
    parseParams(yaml, "test.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(ParamFile, ToYamlRoundTrips) {
  OuterParams written;
  written.fraction = 0.123456;
  written.count = -3;
  written.enabled = false;
  written.name = "true";
  written.list = {-0.5};
  written.inner.sigma_m = 0.25;
  const ParamTree tree = parseParams(toYaml(written), "written");
  OuterParams read;
  assign(tree, "written", read);
  EXPECT_EQ(read.whole, written.whole);
  EXPECT_EQ(read.fraction, written.fraction);
  EXPECT_EQ(read.tiny, written.tiny);
  EXPECT_EQ(read.count, written.count);
  EXPECT_EQ(read.enabled, written.enabled);
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.number, written.number);
  EXPECT_EQ(read.list, written.list);
  EXPECT_EQ(read.texts, written.texts);
  EXPECT_EQ(read.inner.sigma_m, written.inner.sigma_m);
  EXPECT_EQ(tree.size(), describe(written).size());
}

TEST(ParamFile, FlattensNestedGroups) {
  const ParamTree tree = parseParams("a: 1\nb:\n  c: 0.5\n  d:\n    e: text\n", "test.yaml");
  ASSERT_EQ(tree.size(), 3U);
  EXPECT_EQ(std::get<int>(tree.at("a")), 1);
  EXPECT_EQ(std::get<double>(tree.at("b/c")), 0.5);
  EXPECT_EQ(std::get<std::string>(tree.at("b/d/e")), "text");
}

TEST(ParamFile, ReadsScalarsByWhatTheyAre) {
  const ParamTree tree =
      parseParams("i: -4\nd: 1e-3\nb: true\nq: \"7\"\nl: [1, 2]\nt: [a, 2]\n", "test.yaml");
  EXPECT_EQ(std::get<int>(tree.at("i")), -4);
  EXPECT_EQ(std::get<double>(tree.at("d")), 1e-3);
  EXPECT_TRUE(std::get<bool>(tree.at("b")));
  EXPECT_EQ(std::get<std::string>(tree.at("q")), "7");
  EXPECT_EQ(std::get<std::vector<double>>(tree.at("l")), (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(std::get<std::vector<std::string>>(tree.at("t")), (std::vector<std::string>{"a", "2"}));
}

TEST(ParamFile, EmptyTextHasNoParameters) { EXPECT_TRUE(parseParams("# nothing\n", "test.yaml").empty()); }

TEST(ParamFile, NamesTheLineOfASyntaxError) {
  EXPECT_EQ(refusal("a: 1\nb: [1, 2\nc: 3\n").find("test.yaml:"), 0U);
  EXPECT_EQ(refusal("a: 1\nb: 2\n  c: 3\n").find("test.yaml:3:"), 0U) << refusal("a: 1\nb: 2\n  c: 3\n");
}

TEST(ParamFile, RefusesWhatIsNoParameter) {
  EXPECT_NE(refusal("- 1\n- 2\n").find("key: value"), std::string::npos);
  EXPECT_NE(refusal("a:\n").find("\"a\" has no value"), std::string::npos);
  EXPECT_NE(refusal("a: [[1], 2]\n").find("\"a\" must be a list"), std::string::npos);
}

TEST(ParamFile, NamesAMissingFile) {
  try {
    readParamFile("/no/such/file.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("/no/such/file.yaml"), std::string::npos);
  }
}

TEST(ParamFile, LoadsAStructFromAFile) {
  const std::string path = testing::TempDir() + "frugal_nav_param_file_test.yaml";
  std::ofstream(path) << "inner:\n  sigma_m: 0.5\n";
  EXPECT_EQ(loadParamFile<OuterParams>(path).inner.sigma_m, 0.5);
  std::ofstream(path) << "inner:\n  sigma: 0.5\n";
  try {
    loadParamFile<OuterParams>(path);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean \"inner/sigma_m\""), std::string::npos);
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace frugal_nav
