#include <gtest/gtest.h>
#include <support/camera_course.hpp>

// Planner and path follower in a closed loop, with the noise of a camera: rays of 3 cm and 1 %, a common
// error of 3 % an image. Rates and latencies are those of a laptop and of a Raspberry Pi.

namespace frugal_nav {
namespace {

struct Pipeline {
  double rate_hz;
  double latency_s;
};
constexpr Pipeline kFast{5.0, 0.15};
constexpr Pipeline kSlow{1.3, 0.77};
constexpr std::uint64_t kFirstSeed = 500000;

test::CourseResult drive(const test::Course& course, const Pipeline& pipeline, double speed_mps,
                         std::uint64_t seed, const CameraPlannerParams& params = {}) {
  test::CourseRun run;
  run.speed_mps = speed_mps;
  run.rate_hz = pipeline.rate_hz;
  run.latency_s = pipeline.latency_s;
  run.seed = seed;
  run.planner = params;
  run.follower.slow_from_rad = 0.25;
  run.follower.stop_from_rad = 0.6;
  return test::CourseDrive(course, run).drive();
}

TEST(CameraCourse, ReachesThePersonPastStandingObstacles) {
  for (const Pipeline& pipeline : {kFast, kSlow}) {
    for (const double speed : {0.15, 0.25, 0.35}) {
      for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 6; ++seed) {
        const auto result = drive(test::randomCourse(seed, false, speed), pipeline, speed, seed);
        EXPECT_TRUE(result.ok()) << seed << " at " << speed << " m/s, " << pipeline.rate_hz
                                 << " Hz: " << result.what << " " << result.last_reason;
        EXPECT_GT(result.clearance_m, 0.0);
      }
    }
  }
}

TEST(CameraCourse, LetsCrossingWalkersPass) {
  for (const Pipeline& pipeline : {kFast, kSlow}) {
    for (const double speed : {0.15, 0.25, 0.35}) {
      for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 6; ++seed) {
        const auto result = drive(test::randomCourse(seed, true, speed), pipeline, speed, seed);
        EXPECT_TRUE(result.ok()) << seed << " at " << speed << " m/s, " << pipeline.rate_hz
                                 << " Hz: " << result.what << " " << result.last_reason;
      }
    }
  }
}

TEST(CameraCourse, PassesGates) {
  for (const double widths : {1.75, 2.0, 3.0, 4.0}) {
    CameraPlannerParams params;
    if (widths < 2.25) params.halt_width_factor = 1.5;
    for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 5; ++seed) {
      const auto result = drive(test::gateCourse(seed, 0.25 * widths), kFast, 0.25, seed, params);
      EXPECT_TRUE(result.ok()) << seed << ", " << widths << " robot widths: " << result.what << " "
                               << result.last_reason;
    }
  }
}

}  // namespace
}  // namespace frugal_nav
