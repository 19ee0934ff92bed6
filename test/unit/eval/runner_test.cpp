#include <cmath>
#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>

#include <frugal_nav/eval/runner.hpp>

namespace frugal_nav::eval {
namespace {

/// A small run of the quickest suite: a metre-long square each way.
RunRequest smallRun(int trials) {
  RunRequest request;
  request.suite = "odometry";
  request.version = "0.0.0";
  request.context.share_dir = FRUGAL_NAV_SOURCE_DIR;
  request.context.seed = 500000;
  request.trials = trials;
  request.options["side_m"] = 1.0;
  request.options["squares"] = 1;
  return request;
}

TEST(Runner, ThreadsDoNotChangeTheResult) {
  RunRequest request = smallRun(5);
  request.threads = 1;
  const std::string one = toJsonText(runSuite(request));
  request.threads = 4;
  EXPECT_EQ(one, toJsonText(runSuite(request)));
}

TEST(Runner, MergedShardsEqualTheWholeRun) {
  RunRequest request = smallRun(5);
  const std::string whole = toJsonText(runSuite(request));
  std::vector<Result> shards;
  for (const int index : {2, 0, 1}) {
    request.shard = {index, 3};
    const Result shard = runSuite(request);
    const std::string path =
        writeResult(shard, testing::TempDir() + "frugal_nav_shard" + std::to_string(index));
    shards.push_back(readResult(path));
  }
  EXPECT_EQ(whole, toJsonText(mergeResults(shards)));
}

TEST(Runner, MergeRefusesWhatIsNotOneRun) {
  RunRequest request = smallRun(2);
  request.shard = {0, 2};
  const Result first = runSuite(request);
  EXPECT_THROW(mergeResults({first}), ConfigError);         // trial 1 is missing
  EXPECT_THROW(mergeResults({first, first}), ConfigError);  // trial 0 is there twice
  Result other = first;
  other.seed = 2;
  EXPECT_THROW(mergeResults({first, other}), ConfigError);
}

TEST(Runner, TellsProgressOncePerTrial) {
  int calls = 0;
  int last = 0;
  runSuite(smallRun(3), [&](int done, int total) {
    ++calls;
    last = done;
    EXPECT_EQ(total, 3);
  });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(last, 3);
}

TEST(Runner, UnknownOptionIsRefused) {
  RunRequest request = smallRun(1);
  request.options["sides_m"] = 1.0;
  EXPECT_THROW(runSuite(request), ConfigError);
}

TEST(Result, MissingValueIsNullInJsonAndEmptyInCsv) {
  Json row;
  row["trial"] = 0;
  row["nothing"] = orNull(std::nullopt);
  row["not_finite"] = orNull(NAN);
  row["text"] = "a, \"b\"";
  EXPECT_EQ(row.dump(), R"({"trial":0,"nothing":null,"not_finite":null,"text":"a, \"b\""})");
  EXPECT_EQ(toCsvText({row}), "trial,nothing,not_finite,text\n0,,,\"a, \"\"b\"\"\"\n");
}

TEST(Result, FileHasTheAgreedKeysInOrder) {
  Result result;
  result.suite = "odometry";
  result.version = "1.2.3";
  result.seed = 9;
  const Json json = Json::parse(toJsonText(result));
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  EXPECT_EQ(keys, (std::vector<std::string>{"suite", "version", "seed", "options", "rows", "summary"}));
}

TEST(Result, BrokenFileIsNamed) {
  const std::string path = testing::TempDir() + "frugal_nav_broken.json";
  std::ofstream(path) << R"({"suite": "odometry")";
  try {
    readResult(path);
    FAIL() << "a broken file was read";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
  }
  std::remove(path.c_str());
  EXPECT_THROW(readResult(path), ConfigError);
}

}  // namespace
}  // namespace frugal_nav::eval
