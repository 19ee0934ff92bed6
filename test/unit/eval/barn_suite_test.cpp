#include "support/temp_folder.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/eval/runner.hpp>

namespace frugal_nav::eval {
namespace {

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;

std::string cylinder(int number, double x_m, double y_m) {
  const std::string shape =
      "<geometry><cylinder><radius>0.075</radius><length>1</length></cylinder></geometry>";
  return "<model name='unit_cylinder_" + std::to_string(number) + "'><static>1</static><pose frame=''>" +
         std::to_string(x_m) + " " + std::to_string(y_m) +
         " 0 0 0 0</pose><link name='link'><collision name='c'>" + shape + "</collision><visual name='v'>" +
         shape + "</visual></link></model>\n";
}

/// A world of the challenge's format: walls on three sides, and a row of cylinders across with a gap around
/// `gap_x_m`.
std::string worldText(double gap_x_m, double gap_m) {
  std::string models;
  int number = 0;
  for (double y = 0.075; y < 9.6; y += 0.15) {
    models += cylinder(number++, -0.075, y);
    models += cylinder(number++, -4.425, y);
  }
  for (double x = -4.275; x < -0.2; x += 0.15) {
    models += cylinder(number++, x, 0.075);
    if (std::abs(x - gap_x_m) > 0.5 * gap_m + 0.075) models += cylinder(number++, x, 6.0);
  }
  return "<sdf version='1.6'><world name='default'>" + models + "</world></sdf>\n";
}

class BarnSuiteTest : public testing::Test {
 protected:
  Result run() {
    RunRequest request;
    request.suite = "barn";
    request.context.share_dir = kSource;
    request.context.seed = 500000;
    request.options = options;
    return runSuite(request);
  }
  std::string failure() {
    try {
      run();
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }

  test::TempFolder folder;
  ParamTree options{{"worlds", folder.path()}};
};

TEST_F(BarnSuiteTest, DrivesAroundTheCornerOfAWallWithinTheScoredTime) {
  folder.write("world_3.world", worldText(-3.5, 1.0));
  folder.write("path_lengths.csv", "world,path_length_m\n3,10.4\n");
  const Result result = run();
  ASSERT_EQ(result.rows.size(), 2U) << "one a speed";
  EXPECT_EQ(result.summary.at("success_0.5"), 1.0);
  EXPECT_EQ(result.summary.at("success_2.0"), 1.0);
  EXPECT_EQ(result.summary.at("collisions_2.0"), 0);
  EXPECT_LT(result.summary.at("mean_time_2.0_s").get<double>(),
            result.summary.at("mean_time_0.5_s").get<double>());
  for (const Json& row : result.rows) {
    const double optimal_s = 10.4 / 2.0;
    const double time_s = row.at("time_s");
    EXPECT_DOUBLE_EQ(row.at("metric_k2").get<double>(),
                     optimal_s / std::clamp(time_s, 2 * optimal_s, 8 * optimal_s));
    EXPECT_DOUBLE_EQ(row.at("metric_k4").get<double>(),
                     optimal_s / std::clamp(time_s, 4 * optimal_s, 8 * optimal_s));
    EXPECT_GE(time_s, 9.0 / row.at("speed_mps").get<double>() - 0.5)
        << "nine metres at the cap, from 0.1 m on";
  }
}

TEST_F(BarnSuiteTest, AClosedWorldIsATimeOutOrAnAbortAndNoCollision) {
  folder.write("world_1.world", worldText(-10.0, 0.0));
  folder.write("path_lengths.csv", "world,path_length_m\n1,10.4\n");
  options["speeds_mps"] = std::vector<double>{2.0};
  options["rules/time_limit_s"] = 15.0;
  const Result result = run();
  EXPECT_EQ(result.summary.at("success_2.0"), 0.0);
  EXPECT_EQ(result.summary.at("metric_k2_2.0"), 0.0);
  EXPECT_EQ(result.summary.at("collisions_2.0"), 0);
}

TEST_F(BarnSuiteTest, WhatIsMissingIsNamed) {
  EXPECT_NE(failure().find("no file world_NUMBER.world"), std::string::npos);
  folder.write("world_7.world", worldText(-2.0, 1.0));
  EXPECT_NE(failure().find("path_lengths.csv"), std::string::npos);
  folder.write("path_lengths.csv", "world,path_length_m\n8,10.4\n");
  EXPECT_NE(failure().find("no length for world 7"), std::string::npos);
  folder.write("path_lengths.csv", "world,path_length_m\n7;10.4\n");
  EXPECT_NE(failure().find(":2:"), std::string::npos);
  options["methods"] = std::vector<std::string>{"luck"};
  EXPECT_NE(failure().find("luck"), std::string::npos);
  options.erase("worlds");
  options.erase("methods");
  EXPECT_NE(failure().find("--worlds"), std::string::npos);
}

}  // namespace
}  // namespace frugal_nav::eval
