#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/trajectory_metrics.hpp>

namespace frugal_nav::eval {
namespace {

/// The folder of shared data: FRUGAL_NAV_DATA, or ../shared/data beside the source tree.
std::string dataFolder(const std::string& name) {
  const char* given = std::getenv("FRUGAL_NAV_DATA");
  const std::string folder = given != nullptr ? given : FRUGAL_NAV_SOURCE_DIR "/../shared/data";
  return folder + "/" + name + "/";
}

std::vector<PosePair> movedBy(const Alignment& alignment, int count) {
  Random random(500101);
  std::vector<PosePair> pairs;
  for (int i = 0; i < count; ++i) {
    PosePair pair;
    pair.estimate.translation() << random.normal(1.0), random.normal(1.0), random.normal(0.2);
    pair.reference.translation() = alignment * Eigen::Vector3d(pair.estimate.translation());
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(TrajectoryMetrics, AlignmentFindsTheSimilarityThatWasApplied) {
  Alignment truth;
  truth.scale = 2.5;
  truth.rotation = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  truth.translation << 3.0, -1.0, 0.5;
  const std::vector<PosePair> pairs = movedBy(truth, 20);
  const auto found = align(pairs, AlignmentKind::kSimilarity);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, truth.scale, 1e-12);
  EXPECT_LT((found->rotation - truth.rotation).norm(), 1e-12);
  EXPECT_NEAR(absoluteError(pairs, *found).rmse, 0.0, 1e-12);
  EXPECT_GT(absoluteError(pairs, *align(pairs, AlignmentKind::kRigid)).rmse, 0.5);
}

TEST(TrajectoryMetrics, AlignmentNeedsThreePlaces) {
  EXPECT_FALSE(align(movedBy({}, 2), AlignmentKind::kRigid));
  std::vector<PosePair> standing(5);
  EXPECT_FALSE(align(standing, AlignmentKind::kSimilarity));
}

TEST(TrajectoryMetrics, AgreesWithThePublicTool) {
  const std::string folder = dataFolder("trajectories");
  if (!std::filesystem::exists(folder + "expected.json")) GTEST_SKIP() << "no trajectories at " << folder;
  nlohmann::json expected;
  std::ifstream(folder + "expected.json") >> expected;
  struct Case {
    const char* key;
    const char* reference;
    const char* estimate;
    AlignmentKind kind;
  };
  for (const Case& c : {Case{"fr2_desk_ORB", "fr2_desk_groundtruth", "fr2_desk_ORB", AlignmentKind::kRigid},
                        Case{"freiburg1_xyz-rgbdslam", "freiburg1_xyz-groundtruth", "freiburg1_xyz-rgbdslam",
                             AlignmentKind::kRigid},
                        Case{"fr2_desk_ORB_kf_mono_sim3", "fr2_desk_groundtruth", "fr2_desk_ORB_kf_mono",
                             AlignmentKind::kSimilarity}}) {
    SCOPED_TRACE(c.key);
    const std::vector<PosePair> pairs =
        associate(readTumTrajectory(folder + c.reference + ".txt"),
                  readTumTrajectory(folder + c.estimate + ".txt"), fromSeconds(0.02));
    const nlohmann::json& wanted = expected[c.key];
    ASSERT_EQ(pairs.size(), wanted["pairs"].get<std::size_t>());
    const auto alignment = align(pairs, c.kind);
    ASSERT_TRUE(alignment);
    const ErrorStatistics ate = absoluteError(pairs, *alignment);
    const RelativeError rpe = relativeError(pairs);
    EXPECT_NEAR(ate.rmse, wanted["ate_rmse_m"], 1e-6);
    EXPECT_NEAR(ate.mean, wanted["ate_mean_m"], 1e-6);
    EXPECT_NEAR(ate.median, wanted["ate_median_m"], 1e-6);
    EXPECT_NEAR(rpe.translation_rmse_m, wanted["rpe_m_rmse_1frame"], 1e-6);
    EXPECT_NEAR(rpe.rotation_rmse_deg, wanted["rpe_deg_rmse_1frame"], 1e-6);
  }
}

}  // namespace
}  // namespace frugal_nav::eval
