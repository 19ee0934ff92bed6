#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/perception/dbscan.hpp>

namespace frugal_nav {
namespace {

using testing::ElementsAre;

std::vector<Eigen::Vector3d> onALine(const std::vector<double>& places) {
  std::vector<Eigen::Vector3d> points;
  for (const double x : places) points.emplace_back(x, 0.0, 0.0);
  return points;
}

TEST(Dbscan, FindsClustersAndNoiseByHand) {
  // Cores need three points within 1, themselves included: 1 and 2; 11. 0, 3, 10 and 12 are borders, 20 is
  // alone.
  EXPECT_THAT(dbscan(onALine({0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 12.0, 20.0}), 1.0, 3),
              ElementsAre(0, 0, 0, 0, 1, 1, 1, kNoise));
}

TEST(Dbscan, ABorderPointDoesNotJoinTwoClusters) {
  // 2.0 is near the cores 1.0 and 3.0 but has itself only three of the four points that a core needs.
  const auto labels = dbscan(onALine({0.0, 0.5, 0.9, 1.0, 2.0, 3.0, 3.1, 3.5, 4.0}), 1.0, 4);
  EXPECT_THAT(labels, ElementsAre(0, 0, 0, 0, 0, 1, 1, 1, 1));
}

TEST(Dbscan, APointFirstSeenAsNoiseBecomesABorder) {
  EXPECT_THAT(dbscan(onALine({0.0, 1.0, 1.5, 2.0}), 1.0, 3), ElementsAre(0, 0, 0, 0));
}

TEST(Dbscan, NothingGivesNothing) { EXPECT_TRUE(dbscan({}, 1.0, 3).empty()); }

}  // namespace
}  // namespace frugal_nav
