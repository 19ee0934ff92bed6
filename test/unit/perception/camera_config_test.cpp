#include <gtest/gtest.h>
#include <support/param_files.hpp>

#include <frugal_nav/ros/depth_gap_params.hpp>
#include <frugal_nav/ros/goal_detector_params.hpp>
#include <frugal_nav/ros/planning_params.hpp>
#include <frugal_nav/ros/visual_odometry_params.hpp>

namespace frugal_nav {
namespace {

TEST(CameraConfig, DepthGapsFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<DepthGapNodeParams>("depth_gap.yaml");
}

TEST(CameraConfig, GoalDetectorsFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<GoalDetectorNodeParams>("goal_detector.yaml");
}

TEST(CameraConfig, VisualOdometrysFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<VisualOdometryNodeParams>("visual_odometry.yaml");
}

TEST(CameraConfig, CameraPlannersFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<CameraPlannerNodeParams>("camera_planner.yaml");
}

}  // namespace
}  // namespace frugal_nav
