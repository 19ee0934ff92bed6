// Summaries of the suites localization and detector from rows made by hand, and a small run of the latter.
#include <gtest/gtest.h>

#include <frugal_nav/eval/runner.hpp>
#include <frugal_nav/eval/suite.hpp>
#include <frugal_nav/eval/training_scene.hpp>

namespace frugal_nav::eval {
namespace {

const std::string kShare = FRUGAL_NAV_SOURCE_DIR;

Json detection(double score, bool is_hit) {
  return {{"trial", 0}, {"kind", "detection"}, {"score", score}, {"is_hit", is_hit}};
}
Json target(double distance_m, Json error_pct) {
  return {{"trial", 0},
          {"kind", "target"},
          {"distance_m", distance_m},
          {"error_pct", std::move(error_pct)},
          {"true_box_error_pct", nullptr},
          {"height_ratio", 1.0}};
}

TEST(DetectorSuite, PrecisionIsAveragedOverRecall) {
  const Rows rows = {detection(0.7, true), detection(0.9, true), detection(0.8, false), target(2.5, 1.0),
                     target(3.0, -3.0)};
  // By score: hit (precision 1 at recall 1/2), miss, hit (2/3 at recall 1): 1/2 * 1 + 1/2 * 2/3.
  const Json summary = makeSuite("detector")->summarise(rows);
  EXPECT_NEAR(summary.at("ap50"), 5.0 / 6.0, 1e-12);
}

TEST(DetectorSuite, WhatIsMissedCountsAgainstIt) {
  const Rows rows = {detection(0.9, true), target(2.5, 1.0), target(5.0, nullptr), target(3.0, nullptr),
                     target(3.5, nullptr)};
  EXPECT_NEAR(makeSuite("detector")->summarise(rows).at("ap50"), 0.25, 1e-12);
}

TEST(DetectorSuite, DistanceErrorsAreAbsoluteAndByRange) {
  const Rows rows = {target(2.5, 4.0), target(3.9, -2.0), target(4.1, 8.0), target(5.0, nullptr)};
  const Json summary = makeSuite("detector")->summarise(rows);
  EXPECT_NEAR(summary.at("distance_error_2_4m_pct"), 3.0, 1e-12);
  EXPECT_NEAR(summary.at("distance_error_4_6m_pct"), 8.0, 1e-12);
  EXPECT_EQ(summary.at("targets"), 4);
}

TEST(DetectorSuite, NothingToFindHasNoPrecision) {
  EXPECT_TRUE(makeSuite("detector")->summarise({detection(0.9, false)}).at("ap50").is_null());
}

TEST(DetectorSuite, SameSeedGivesTheSameRowsButForTheTime) {
  RunRequest request;
  request.suite = "detector";
  request.context.share_dir = kShare;
  request.context.seed = 500000;
  request.trials = 2;
  request.options = {{"frames", 1}, {"width_px", 320}, {"views", 1}};
  Result first = runSuite(request);
  request.threads = 1;
  Result second = runSuite(request);
  for (Rows* rows : {&first.rows, &second.rows}) {
    for (Json& row : *rows) row.erase("detect_ms");
  }
  EXPECT_EQ(first.rows, second.rows);
  EXPECT_EQ(first.rows[0].at("kind"), "scene");
}

TEST(UnseenScene, SeedsOfTrainingAndOfEvaluationDoNotMix) {
  EXPECT_THROW(makeUnseenScene(kFirstTrainingSeed, {}), ConfigError);
  EXPECT_THROW(makeTrainingScene(kFirstTrainingSeed - 1, {}), ConfigError);
}

Json drive(const std::string& light, const std::string& course, double wheel, double tracking) {
  Json row = {{"trial", 0}, {"light", light}, {"course", course}};
  for (const char* key : {"ate_wheel_m", "drift_wheel_pct"}) row[key] = wheel;
  for (const char* key :
       {"ate_vo_tracking_m", "ate_vo_matching_m", "drift_vo_tracking_pct", "drift_vo_matching_pct",
        "map_error_m", "map_points", "tracked_tracking", "tracked_matching", "anees_vo_tracking"})
    row[key] = tracking;
  return row;
}

TEST(LocalizationSuite, DriftIsThatOfTheCornerAndErrorsAreByLight) {
  const Rows rows = {drive("daylight", "corner", 1.0, 2.0), drive("daylight", "square", 3.0, 6.0),
                     drive("dim", "corner", 1.0, 8.0)};
  const Json summary = makeSuite("localization")->summarise(rows);
  EXPECT_NEAR(summary.at("drift_wheel_pct"), 1.0, 1e-12);
  EXPECT_NEAR(summary.at("ate_wheel_m"), 5.0 / 3.0, 1e-12);
  EXPECT_NEAR(summary.at("drift_vo_daylight_pct"), 2.0, 1e-12);
  EXPECT_NEAR(summary.at("ate_vo_tracking_daylight_m"), 4.0, 1e-12);
  EXPECT_NEAR(summary.at("drift_vo_dim_pct"), 8.0, 1e-12);
  EXPECT_TRUE(summary.at("drift_vo_tube_pct").is_null());
}

}  // namespace
}  // namespace frugal_nav::eval
