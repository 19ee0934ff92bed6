// The depth network's conventions, on networks that the test writes.
#include "../../../src/eval/onnx_writer.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <support/message_of.hpp>
#include <support/temp_folder.hpp>

#include <frugal_nav/perception/depth_choice.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav::eval {
namespace {

using test::messageOf;
using testing::HasSubstr;

/// A network that weighs the three channels of each pixel: `weights` for each output channel.
std::string weighing(const std::vector<float>& weights, std::int64_t outputs = 1) {
  OnnxWriter writer({3, 32, 48});
  writer.finish(writer.convolve(writer.input(), {outputs, 1, 1, false}, weights));
  return writer.bytes();
}

/// A network that takes no input of an odd height: half of it, doubled, is added to the whole.
std::string takingEvenHeights() {
  OnnxWriter writer({3, 32, 48});
  const auto whole = writer.convolve(writer.input(), {1, 1, 1, false}, {1.0F, 1.0F, 1.0F});
  const auto half = writer.convolve(writer.input(), {1, 1, 2, false}, {1.0F, 1.0F, 1.0F});
  writer.finish(writer.add(whole, writer.upsample(half)));
  return writer.bytes();
}

class DepthNetworks : public testing::Test {
 protected:
  DepthNetworks() {
    params_.input_width_px = 48;
    params_.input_height_px = 32;
  }
  std::unique_ptr<OnnxDepthNetwork> network(const std::string& bytes) {
    params_.model = folder_.write("network.onnx", bytes);
    return std::make_unique<OnnxDepthNetwork>(params_);
  }
  test::TempFolder folder_;
  DepthNetworkParams params_;
  const cv::Mat image_{64, 96, CV_8UC3, cv::Scalar(51, 102, 204)};  // blue 0.2, green 0.4, red 0.8
};

TEST_F(DepthNetworks, TakeRgbLessTheMeanOverTheDeviation) {
  const cv::Mat red = network(weighing({1.0F, 0.0F, 0.0F}))->infer(image_).inverse;
  EXPECT_EQ(red.size(), cv::Size(48, 32));
  EXPECT_EQ(red.type(), CV_32FC1);
  EXPECT_NEAR(red.at<float>(3, 5), (0.8 - 0.485) / 0.229, 1e-4);
  const cv::Mat blue = network(weighing({0.0F, 0.0F, -1.0F}))->infer(image_).inverse;
  EXPECT_NEAR(blue.at<float>(3, 5), -(0.2 - 0.406) / 0.225, 1e-4);
}

TEST_F(DepthNetworks, MayHaveTheNormalisationInside) {
  params_.is_normalised_inside = true;
  EXPECT_NEAR(network(weighing({1.0F, 0.0F, 0.0F}))->infer(image_).inverse.at<float>(3, 5), 0.8, 1e-4);
  params_.color_order = "bgr";
  EXPECT_NEAR(network(weighing({1.0F, 0.0F, 0.0F}))->infer(image_).inverse.at<float>(3, 5), 0.2, 1e-4);
}

TEST_F(DepthNetworks, RelativeInverseDepthIsNeverNegative) {
  EXPECT_EQ(network(weighing({-1.0F, 0.0F, 0.0F}))->infer(image_).inverse.at<float>(3, 5), 0.0F);
}

TEST_F(DepthNetworks, MetricOnesGiveOneOverMetres) {
  params_.output = "metric";
  params_.is_normalised_inside = true;
  const auto metric = network(weighing({5.0F, 0.0F, 0.0F}));
  EXPECT_TRUE(metric->isMetric());
  EXPECT_NEAR(metric->infer(image_).inverse.at<float>(3, 5), 1.0 / 4.0, 1e-5);
}

TEST_F(DepthNetworks, NoNumbersStayNoNumbers) {
  params_.is_normalised_inside = true;
  const cv::Mat map =
      network(weighing({std::numeric_limits<float>::infinity(), 0.0F, 0.0F}))->infer(image_).inverse;
  EXPECT_FALSE(std::isfinite(map.at<float>(3, 5)));
}

TEST_F(DepthNetworks, OfAnotherShapeAreNamed) {
  const std::string message = messageOf([this] { network(weighing({1, 0, 0, 0, 1, 0}, 2)); });
  EXPECT_THAT(message, HasSubstr("network.onnx"));
  EXPECT_THAT(message, HasSubstr("1x2x32x48"));
  EXPECT_THAT(message, HasSubstr("1x1xHxW"));
}

TEST_F(DepthNetworks, OfAnotherInputSizeAreNamed) {
  params_.input_height_px = 33;
  const std::string message = messageOf([this] { network(takingEvenHeights()); });
  EXPECT_THAT(message, HasSubstr("network.onnx"));
  EXPECT_THAT(message, HasSubstr("1x3x33x48"));
  params_.input_height_px = 32;
  EXPECT_EQ(network(takingEvenHeights())->infer(image_).inverse.size(), cv::Size(48, 32));
}

TEST_F(DepthNetworks, WithoutTheFloorsOutputAreNamedWithTheirOwn) {
  params_.floor_output = "floor";
  const std::string message = messageOf([this] { network(weighing({1.0F, 0.0F, 0.0F})); });
  EXPECT_THAT(message, HasSubstr("network.onnx"));
  EXPECT_THAT(message, HasSubstr("no output floor but output"));
}

TEST_F(DepthNetworks, MissingAndCorruptFilesAreNamedWithWhatToDo) {
  params_.model = folder_.path("none.onnx");
  EXPECT_THAT(messageOf([this] { OnnxDepthNetwork{params_}; }), HasSubstr("put the model there"));
  EXPECT_THAT(messageOf([this] { network("this is no network"); }), HasSubstr("fetch it again"));
}

TEST(DepthChoice, FindsTheShippedNetwork) {
  const DepthChoice choice;
  const auto network = makeDepthNetwork(choice, FRUGAL_NAV_SOURCE_DIR);
  EXPECT_FALSE(network->isMetric());
  cv::Mat image(312, 416, CV_8UC3);
  cv::RNG(500001).fill(image, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat first = network->infer(image).inverse;
  const cv::Mat kept = first.clone();
  network->infer(cv::Mat(312, 416, CV_8UC3, cv::Scalar::all(90)));
  EXPECT_EQ(cv::norm(first, kept, cv::NORM_INF), 0.0);  // a map is the caller's
  EXPECT_EQ(cv::norm(network->infer(image).inverse, kept, cv::NORM_INF), 0.0);
}

TEST(DepthChoice, ModelFilesAreSound) {
  for (const char* name : {"depth_small", "midas_v21_small", "fast_depth"}) {
    DepthChoice choice;
    choice.model = name;
    EXPECT_NO_THROW(loadParamFile<DepthNetworkParams>(configOf(choice, FRUGAL_NAV_SOURCE_DIR))) << name;
  }
}

}  // namespace
}  // namespace frugal_nav::eval
