#include "support/temp_folder.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <frugal_nav/eval/midas_sized_network.hpp>
#include <frugal_nav/perception/depth_network.hpp>

namespace frugal_nav::eval {
namespace {

TEST(MidasSizedNetwork, HasTheCostAndTheShapesOfMidasSmall) {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/network.onnx";
  const NetworkCost cost = writeMidasSizedNetwork(path);
  // 16.6 million parameters (the published file has 66.7 MB) and 4.6 GMAC at 256x256.
  EXPECT_NEAR(cost.parameters, 16.6e6, 0.1e6);
  EXPECT_NEAR(cost.macs, 4.6e9, 0.1e9);

  DepthNetworkParams params;  // MiDaS v2.1 small's conventions
  params.model = path;
  OnnxDepthNetwork network(params);
  cv::Mat image(312, 416, CV_8UC3);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat inverse = network.infer(image).inverse;
  EXPECT_EQ(inverse.size(), cv::Size(256, 256));
  EXPECT_TRUE(cv::checkRange(inverse));
  double least = -1.0;
  double most = 0.0;
  cv::minMaxLoc(inverse, &least, &most);
  EXPECT_GE(least, 0.0);
  EXPECT_GT(most, least);
}

}  // namespace
}  // namespace frugal_nav::eval
