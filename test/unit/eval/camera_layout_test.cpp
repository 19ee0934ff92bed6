#include "../../../src/eval/random_paint.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/eval/camera_layout.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kRobotWidth_m = 0.25;
constexpr std::uint64_t kFirstSeed = 500000;

class CameraLayoutTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    textures_ =
        new std::vector<sim::Texture>(readTextures(std::string(FRUGAL_NAV_SOURCE_DIR) + "/worlds/textures"));
  }
  static void TearDownTestSuite() { delete textures_; }
  static CameraLayout make(std::uint64_t seed) { return makeCameraLayout(seed, kRobotWidth_m, *textures_); }

  static std::vector<sim::Texture>* textures_;
};
std::vector<sim::Texture>* CameraLayoutTest::textures_ = nullptr;

TEST_F(CameraLayoutTest, IsWhatTheTrialsAskFor) {
  constexpr int kLayouts = 20;
  int walkers = 0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kLayouts; ++seed) {
    const CameraLayout layout = make(seed);
    SCOPED_TRACE(seed);
    EXPECT_GE(layout.p_person.norm(), 4.0);
    EXPECT_LE(layout.p_person.norm(), 7.0);
    EXPECT_NEAR((layout.p_person - layout.p_stand_off).norm(), kStandOff_m, 1e-9);
    EXPECT_GE(layout.obstacles.size(), 1U);
    EXPECT_LE(layout.obstacles.size(), 3U);
    // The grid tells widths to a cell's diagonal, 0.07 m.
    EXPECT_GE(layout.gap_m, 1.5 * kRobotWidth_m - 0.07);
    EXPECT_LE(layout.gap_m, 4.0 * kRobotWidth_m + 0.07);
    EXPECT_FALSE(layout.solids.empty());
    walkers += layout.crossing ? 1 : 0;
    EXPECT_EQ(layout.scene.people.size(), layout.crossing ? 2U : 1U);
  }
  // Half of them; fewer than 3 or more than 17 of 20 has a chance of 0.0004.
  EXPECT_GE(walkers, 3);
  EXPECT_LE(walkers, 17);
}

TEST_F(CameraLayoutTest, AnObstacleStandsOnTheStraightLine) {
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 20; ++seed) {
    const CameraLayout layout = make(seed);
    double nearest_m = 10.0;
    constexpr int kSteps = 200;
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d p = layout.p_stand_off * i / kSteps;
      for (const Solid& obstacle : layout.obstacles) nearest_m = std::min(nearest_m, obstacle.distanceTo(p));
    }
    EXPECT_LT(nearest_m, 0.5 * kRobotWidth_m) << seed;
  }
}

TEST_F(CameraLayoutTest, TheSameSeedGivesTheSameLayout) {
  const CameraLayout first = make(kFirstSeed);
  const CameraLayout second = make(kFirstSeed);
  const CameraLayout other = make(kFirstSeed + 1);
  EXPECT_EQ(first.p_person, second.p_person);
  EXPECT_EQ(first.light, second.light);
  ASSERT_EQ(first.solids.size(), second.solids.size());
  for (std::size_t i = 0; i < first.solids.size(); ++i)
    EXPECT_EQ(first.solids[i].world_from_solid.position(), second.solids[i].world_from_solid.position());
  EXPECT_NE(first.p_person, other.p_person);
}

}  // namespace
}  // namespace frugal_nav::eval
