#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {
namespace {

struct GainParams {
  double kp = 1.5;
  bool windup_guard = true;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("kp", kp, Field{"1/s", "proportional gain", 0.0, 10.0});
    visit("windup_guard", windup_guard, Field{"", "whether the integral stops at the limit"});
  }
};

struct DriveParams {
  double max_v_mps = 0.5;
  double slow_v_mps = 0.1;
  int cycles = 3;
  std::string method = "sectors";
  std::vector<double> weights{1.0, 0.25};
  std::vector<std::string> sources{"scan", "image"};
  GainParams gain;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_v_mps", max_v_mps, Field{"m/s", "fastest drive", 0.01, 2.0});
    visit("slow_v_mps", slow_v_mps, Field{"m/s", "drive near obstacles", 0.0, 2.0});
    visit("cycles", cycles, Field{"", "cycles to wait", 1, 100});
    visit("method", method, Field{"", "avoidance", 0, 0, "sectors|vfh_plus"});
    visit("weights", weights, Field{"", "of both terms", 0.0, 1.0});
    visit("sources", sources, Field{"", "where obstacles come from", {}, {}, "scan|image|depth"});
    visit("gain", gain);
  }
  std::string check() const { return slow_v_mps <= max_v_mps ? "" : "slow_v_mps exceeds max_v_mps"; }
};

/// The message with which a tree is refused.
std::string refusal(const ParamTree& tree) {
  DriveParams params;
  try {
    assign(tree, "drive.yaml", params);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

void expectNames(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << '"' << part << "\" is not in: " << message;
}

TEST(Params, TakesWhatIsNamedAndKeepsTheRest) {
  DriveParams params;
  assign({{"max_v_mps", 0.8}, {"method", std::string("vfh_plus")}, {"gain/kp", 2.0}}, "drive.yaml", params);
  EXPECT_EQ(params.max_v_mps, 0.8);
  EXPECT_EQ(params.method, "vfh_plus");
  EXPECT_EQ(params.gain.kp, 2.0);
  EXPECT_EQ(params.cycles, 3);
  EXPECT_TRUE(params.gain.windup_guard);
}

TEST(Params, SuggestsTheNearestForAnUnknownKey) {
  expectNames(refusal({{"max_v_msp", 0.8}}), {"drive.yaml", "max_v_msp", "did you mean \"max_v_mps\""});
  expectNames(refusal({{"gain/pk", 0.8}}), {"gain/pk", "did you mean \"gain/kp\""});
}

TEST(Params, ConvertsAnIntegerToANumber) {
  DriveParams params;
  assign({{"max_v_mps", 1}}, "drive.yaml", params);
  EXPECT_EQ(params.max_v_mps, 1.0);
}

TEST(Params, AnEmptyListIsOneOfTexts) {  // YAML and the parameter server cannot tell
  DriveParams params;
  assign({{"sources", std::vector<double>()}}, "drive.yaml", params);
  EXPECT_TRUE(params.sources.empty());
}

TEST(Params, RefusesAWrongType) {
  expectNames(refusal({{"cycles", 2.5}}), {"drive.yaml", "cycles", "an integer", "2.5"});
  expectNames(refusal({{"max_v_mps", std::string("fast")}}), {"max_v_mps", "a number", "fast"});
  expectNames(refusal({{"gain/windup_guard", 1}}), {"gain/windup_guard", "true/false"});
  expectNames(refusal({{"method", true}}), {"method", "a text"});
}

TEST(Params, RefusesValuesOutOfRange) {
  expectNames(refusal({{"max_v_mps", 3.0}}), {"max_v_mps", "3", "[0.01, 2] m/s"});
  expectNames(refusal({{"max_v_mps", NAN}}), {"max_v_mps", "nan"});
  expectNames(refusal({{"cycles", 0}}), {"cycles", "0", "[1, 100]"});
  expectNames(refusal({{"weights", std::vector<double>{0.5, 1.5}}}), {"weights", "1.5"});
  expectNames(refusal({{"gain/kp", -1.0}}), {"gain/kp", "-1"});
  expectNames(refusal({{"method", std::string("astar")}}), {"method", "astar", "sectors|vfh_plus"});
}

TEST(Params, RefusesPartOfAChoice) {
  expectNames(refusal({{"method", std::string("sector")}}), {"method", "none of"});
  expectNames(refusal({{"method", std::string("")}}), {"method", "none of"});
}

TEST(Params, RefusesAListWithWhatIsNoChoice) {
  const std::vector<std::string> sources = {"scan", "sonar"};
  expectNames(refusal({{"sources", sources}}), {"sources", "sonar", "none of scan|image|depth"});
}

TEST(Params, RefusesContradictions) {
  expectNames(refusal({{"slow_v_mps", 0.6}}), {"drive.yaml", "slow_v_mps exceeds max_v_mps"});
}

TEST(Params, DefaultsOfTheListAreSound) { EXPECT_EQ(findFault(DriveParams{}), ""); }

TEST(Params, DescribesEveryFieldOnce) {
  const auto rows = describe(DriveParams{});
  ASSERT_EQ(rows.size(), 8U);
  EXPECT_EQ(rows.front().name, "max_v_mps");
  EXPECT_EQ(rows.back().name, "gain/windup_guard");
  EXPECT_STREQ(rows.front().field.unit, "m/s");
}

TEST(Params, WritesGroupsUnitsAndRanges) {
  const std::string yaml = toYaml(DriveParams{});
  expectNames(
      yaml, {"max_v_mps: 0.5  # [m/s] fastest drive; from 0.01 to 2\n", "gain:\n  kp: 1.5  # [1/s]",
             "method: \"sectors\"  # avoidance; one of sectors|vfh_plus", "sources: [\"scan\", \"image\"]"});
}

}  // namespace
}  // namespace frugal_nav
