#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/eval/json.hpp>
#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/perception/depth_network.hpp>

namespace frugal_nav::eval {

/// A real recording: images, depth images in millimetres, K.txt, poses.txt (camera to world, a line each).
struct RgbdRecording {
  std::vector<std::string> images;
  std::vector<std::string> depths;
  std::vector<Eigen::Isometry3d> world_from_camera;
  Pinhole camera;
};

/// Reads what a folder holds; throws ConfigError naming what is missing.
RgbdRecording readRgbdRecording(const std::string& folder);

/// One row a frame: mean relative errors of the network alone, of the network scaled so that its median is
/// the true one, and fused with the points of visual odometry, whose scale the poses' distances give. The
/// last is null in frames without points; depth is the truth alone.
Rows measureRgbd(const RgbdRecording& recording, DepthNetwork& network, const DepthGapParams& params);

}  // namespace frugal_nav::eval
