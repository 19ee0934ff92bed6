#include <gtest/gtest.h>

#include <frugal_nav/eval/command_line.hpp>

namespace frugal_nav::eval {
namespace {

using Action = EvaluateCommand::Action;

std::string faultOf(const std::vector<std::string>& arguments) {
  try {
    parseCommandLine(arguments);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(CommandLine, ReadsRunAndSuiteOptions) {
  const EvaluateCommand command = parseCommandLine({"odometry", "--seed", "7", "--trials=3", "--out", "dir",
                                                    "--shard", "1/4", "--side_m", "2", "--squares=2"});
  EXPECT_EQ(command.action, Action::kRun);
  EXPECT_EQ(command.request.context.seed, 7U);
  EXPECT_EQ(command.request.trials, 3);
  EXPECT_EQ(command.out, "dir");
  EXPECT_EQ(command.request.shard.index, 1);
  EXPECT_EQ(command.request.shard.count, 4);
  EXPECT_EQ(std::get<double>(command.request.options.at("side_m")), 2.0);
  EXPECT_EQ(std::get<int>(command.request.options.at("squares")), 2);
}

TEST(CommandLine, NamesTheNearestKnown) {
  EXPECT_NE(faultOf({"odometri"}).find("did you mean 'odometry'"), std::string::npos);
  EXPECT_NE(faultOf({"odometry", "--sed", "1"}).find("did you mean --seed"), std::string::npos);
  EXPECT_NE(faultOf({"odometry", "--square", "1"}).find("did you mean --squares"), std::string::npos);
  EXPECT_NE(faultOf({"--lst"}).find("did you mean --list"), std::string::npos);
}

TEST(CommandLine, RefusesWhatIsNoNumber) {
  EXPECT_NE(faultOf({"odometry", "--seed", "-1"}).find("--seed"), std::string::npos);
  EXPECT_NE(faultOf({"odometry", "--trials", "0"}).find("--trials"), std::string::npos);
  EXPECT_NE(faultOf({"odometry", "--trials"}).find("lacks its value"), std::string::npos);
  EXPECT_NE(faultOf({"odometry", "--squares", "many"}).find("--squares"), std::string::npos);
  for (const char* shard : {"1", "1/1", "-1/2", "a/b", "0/0", "0/2x"})
    EXPECT_NE(faultOf({"odometry", "--shard", shard}).find("--shard"), std::string::npos) << shard;
}

TEST(CommandLine, HelpNamesEverySuiteAndItsOptions) {
  EXPECT_EQ(parseCommandLine({}).action, Action::kHelp);
  EXPECT_EQ(parseCommandLine({"--list"}).action, Action::kList);
  EXPECT_EQ(parseCommandLine({"odometry", "--help"}).action, Action::kHelp);
  for (const auto& suite : suites()) {
    EXPECT_NE(listText().find(suite.first), std::string::npos);
    const std::string help = helpText(suite.first);
    for (const FieldDescription& option : suite.second()->options())
      EXPECT_NE(help.find("--" + option.name), std::string::npos) << suite.first;
  }
}

TEST(CommandLine, MergeTakesAPlaceAndFiles) {
  const EvaluateCommand command = parseCommandLine({"--merge", "out", "a.json", "b.json"});
  EXPECT_EQ(command.action, Action::kMerge);
  EXPECT_EQ(command.out, "out");
  EXPECT_EQ(command.sources, (std::vector<std::string>{"a.json", "b.json"}));
  EXPECT_NE(faultOf({"--merge", "out"}).find("--merge"), std::string::npos);
}

}  // namespace
}  // namespace frugal_nav::eval
