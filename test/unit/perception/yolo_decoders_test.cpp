#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <support/message_of.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {
namespace {

using test::messageOf;
using testing::HasSubstr;

const float kNaN = std::numeric_limits<float>::quiet_NaN();

cv::Mat tensor(const std::vector<int>& shape) {
  return cv::Mat(static_cast<int>(shape.size()), shape.data(), CV_32F, cv::Scalar(0));
}

void setRow(cv::Mat& output, int row, const std::vector<float>& values) {
  std::copy(values.begin(), values.end(), output.ptr<float>() + row * static_cast<int>(values.size()));
}

DecodeOptions options(int classes, cv::Size input = {64, 64}) { return {"test.onnx", input, classes, 0.3}; }

void expectBox(const Detection& detection, double x, double y, double width, double height) {
  EXPECT_NEAR(detection.box.x, x, 1e-4);
  EXPECT_NEAR(detection.box.y, y, 1e-4);
  EXPECT_NEAR(detection.box.width, width, 1e-4);
  EXPECT_NEAR(detection.box.height, height, 1e-4);
}

TEST(DecodeYolov5, MultipliesObjectnessByTheBestClass) {
  cv::Mat output = tensor({1, 3, 7});
  setRow(output, 0, {20, 30, 10, 8, 0.9F, 0.2F, 0.8F});  // 0.72, class 1
  setRow(output, 1, {40, 30, 10, 8, 0.5F, 0.5F, 0.1F});  // 0.25: below 0.3
  setRow(output, 2, {40, 30, 10, 8, 0.2F, 1.0F, 0.1F});  // objectness alone is below
  const DecodedBoxes decoded = decodeYolov5(output, options(2));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_EQ(decoded.boxes[0].class_id, 1);
  EXPECT_NEAR(decoded.boxes[0].score, 0.72, 1e-6);
  expectBox(decoded.boxes[0], 15, 26, 10, 8);
}

TEST(DecodeYolov5, TakesObjectnessAloneOfOneClass) {
  cv::Mat output = tensor({1, 1, 6});
  setRow(output, 0, {20, 30, 10, 8, 0.9F, 0.1F});
  const DecodedBoxes decoded = decodeYolov5(output, options(1));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_NEAR(decoded.boxes[0].score, 0.9, 1e-6);
}

TEST(DecodeYolov5, SkipsAndCountsRowsThatAreNoNumbers) {
  cv::Mat output = tensor({1, 4, 7});
  setRow(output, 0, {kNaN, 30, 10, 8, 0.9F, 0.2F, 0.8F});
  setRow(output, 1, {20, 30, 10, 8, kNaN, 0.2F, 0.8F});
  setRow(output, 2, {20, 30, 10, 8, 0.9F, 0.2F, std::numeric_limits<float>::infinity()});
  setRow(output, 3, {20, 30, 10, 8, 0.9F, 0.2F, 0.8F});
  const DecodedBoxes decoded = decodeYolov5(output, options(2));
  EXPECT_EQ(decoded.boxes.size(), 1U);
  EXPECT_EQ(decoded.not_finite, 3U);
}

TEST(DecodeYolov8, ReadsChannelsFirstWithoutObjectness) {
  cv::Mat output = tensor({1, 6, 84});  // 64 + 16 + 4 cells
  const auto set = [&output](int field, int box, float value) {
    output.ptr<float>()[field * 84 + box] = value;
  };
  const std::vector<float> row = {20, 30, 10, 8, 0.1F, 0.6F};
  for (int field = 0; field < 6; ++field) set(field, 33, row[static_cast<std::size_t>(field)]);
  set(5, 50, kNaN);
  const DecodedBoxes decoded = decodeYolov8(output, options(2));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_EQ(decoded.boxes[0].class_id, 1);
  EXPECT_NEAR(decoded.boxes[0].score, 0.6, 1e-6);
  expectBox(decoded.boxes[0], 15, 26, 10, 8);
  EXPECT_EQ(decoded.not_finite, 1U);
}

// A 96x64 input has 12x8 cells of 8, 6x4 of 16, 3x2 of 32: rows 0..95, 96..119, 120..125.
TEST(DecodeYolox, PutsTheGridOnItsThreeStrides) {
  cv::Mat output = tensor({1, 126, 7});
  const float two = std::log(2.0F);
  setRow(output, 12 * 3 + 5, {0.5F, 0.25F, two, 0, 1.0F, 0.2F, 0.9F});       // stride 8, column 5, row 3
  setRow(output, 96 + 6 * 2 + 4, {0.5F, 0.25F, two, 0, 1.0F, 0.2F, 0.8F});   // stride 16, column 4, row 2
  setRow(output, 120 + 3 * 1 + 2, {0.5F, 0.25F, two, 0, 1.0F, 0.2F, 0.7F});  // stride 32, column 2, row 1
  const DecodedBoxes decoded = decodeYolox(output, options(2, {96, 64}));
  ASSERT_EQ(decoded.boxes.size(), 3U);
  expectBox(decoded.boxes[0], 8 * 5.5 - 8, 8 * 3.25 - 4, 16, 8);
  expectBox(decoded.boxes[1], 16 * 4.5 - 16, 16 * 2.25 - 8, 32, 16);
  expectBox(decoded.boxes[2], 32 * 2.5 - 32, 32 * 1.25 - 16, 64, 32);
  EXPECT_NEAR(decoded.boxes[2].score, 0.7, 1e-6);
}

TEST(DecodeYolox, CountsASizeThatOverflows) {
  cv::Mat output = tensor({1, 126, 6});
  setRow(output, 0, {0, 0, 1000.0F, 0, 1.0F, 1.0F});  // exp(1000)
  const DecodedBoxes decoded = decodeYolox(output, options(1, {96, 64}));
  EXPECT_TRUE(decoded.boxes.empty());
  EXPECT_EQ(decoded.not_finite, 1U);
}

class RawHeads : public testing::TestWithParam<bool> {
 protected:
  /// A head of two anchors and two classes in one of its two layouts, objectness -10 everywhere.
  cv::Mat makeHead(int rows, int columns) const {
    cv::Mat head = fieldsLast() ? tensor({1, 2, rows, columns, 7}) : tensor({1, 14, rows, columns});
    for (int a = 0; a < 2; ++a) {
      for (int r = 0; r < rows; ++r) {
        for (int c = 0; c < columns; ++c) *at(head, a, r, c, 4) = -10.0F;
      }
    }
    return head;
  }
  float* at(cv::Mat& head, int a, int r, int c, int field) const {
    const int rows = head.size[2];
    const int columns = head.size[3];
    return head.ptr<float>() + (fieldsLast() ? ((a * rows + r) * columns + c) * 7 + field
                                             : ((a * 7 + field) * rows + r) * columns + c);
  }
  void set(cv::Mat& head, int a, int r, int c, const std::vector<float>& values) const {
    for (int field = 0; field < 7; ++field)
      *at(head, a, r, c, field) = values[static_cast<std::size_t>(field)];
  }
  static bool fieldsLast() { return GetParam(); }
};

// sigmoid(0) = 0.5, sigmoid(ln 3) = 0.75, sigmoid(ln 4) = 0.8.
TEST_P(RawHeads, FollowYolov5) {
  cv::Mat fine = makeHead(4, 6);    // stride 16 of a 96x64 input
  cv::Mat coarse = makeHead(2, 3);  // stride 32
  const float ln3 = std::log(3.0F);
  set(fine, 1, 2, 5, {ln3, 0, 0, ln3, std::log(4.0F), -1, ln3});
  set(coarse, 0, 1, 2, {0, 0, 0, 0, std::log(4.0F), 10, 0});
  AnchorOptions anchors;
  anchors.anchors = {4, 5, 10, 12, 30, 31, 50, 60};
  // The order of the heads does not matter: their cells tell the finest.
  const DecodedBoxes decoded = decodeRawHeads({coarse, fine}, anchors, options(2, {96, 64}));
  ASSERT_EQ(decoded.boxes.size(), 2U);
  // centre (2 * 0.75 - 0.5 + 5) * 16 = 96, (2 * 0.5 - 0.5 + 2) * 16 = 40; size 1 * 10, 1.5^2 * 12 = 27.
  expectBox(decoded.boxes[0], 96 - 5, 40 - 13.5, 10, 27);
  EXPECT_EQ(decoded.boxes[0].class_id, 1);
  EXPECT_NEAR(decoded.boxes[0].score, 0.8 * 0.75, 1e-6);
  // centre (0.5 + 2) * 32 = 80, (0.5 + 1) * 32 = 48; size of the first anchor of the coarse head.
  expectBox(decoded.boxes[1], 80 - 15, 48 - 15.5, 30, 31);
  EXPECT_NEAR(decoded.boxes[1].score, 0.8 / (1 + std::exp(-10.0)), 1e-6);
}

TEST_P(RawHeads, FollowDarknet) {
  cv::Mat head = makeHead(4, 6);
  const float ln3 = std::log(3.0F);
  set(head, 1, 2, 5, {ln3, 0, std::log(2.0F), 0, std::log(4.0F), -1, ln3});
  AnchorOptions anchors;
  anchors.coding = BoxCoding::kDarknet;
  anchors.anchors = {4, 5, 10, 12};
  anchors.scale_xy = {1.2};
  const DecodedBoxes decoded = decodeRawHeads({head}, anchors, options(2, {96, 64}));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  // centre (1.2 * 0.75 - 0.1 + 5) * 16 = 92.8, (1.2 * 0.5 - 0.1 + 2) * 16 = 40; size 2 * 10, 12.
  expectBox(decoded.boxes[0], 92.8 - 10, 40 - 6, 20, 12);
  EXPECT_NEAR(decoded.boxes[0].score, 0.8 * 0.75, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Layouts, RawHeads, testing::Values(true, false));

TEST(DecodeRawHeads, TakeObjectnessAloneOfOneClass) {
  cv::Mat head = tensor({1, 1, 2, 3, 6});
  for (int cell = 0; cell < 6; ++cell) setRow(head, cell, {0, 0, 0, 0, -10, 0});
  setRow(head, 4, {0, 0, 0, 0, std::log(4.0F), -5});
  AnchorOptions anchors;
  anchors.anchors = {10, 12};
  const DecodedBoxes decoded = decodeRawHeads({head}, anchors, options(1, {96, 64}));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_NEAR(decoded.boxes[0].score, 0.8, 1e-6);
  expectBox(decoded.boxes[0], 1.5 * 32 - 5, 1.5 * 32 - 6, 10, 12);
}

TEST(DecodeRawHeads, WantsAnchorsThatShareOut) {
  AnchorOptions anchors;
  anchors.anchors = {4, 5, 10};
  const auto decode = [&] { decodeRawHeads({tensor({1, 2, 4, 6, 7})}, anchors, options(2, {96, 64})); };
  EXPECT_THAT(messageOf(decode), HasSubstr("3 numbers of anchors"));
}

TEST(DecodeRawHeads, RefusesAGridOfAnotherInput) {
  AnchorOptions anchors;
  anchors.anchors = {4, 5, 10, 12};
  const auto decode = [&] { decodeRawHeads({tensor({1, 2, 5, 6, 7})}, anchors, options(2, {96, 64})); };
  EXPECT_THAT(messageOf(decode), HasSubstr("1x2x5x6x7"));
}

TEST(DecodeEndToEnd, ReadsCornersAndLeavesPaddingOut) {
  cv::Mat output = tensor({3, 7});
  setRow(output, 0, {0, 10, 20, 30, 50, 3, 0.9F});
  setRow(output, 1, {-1, 10, 20, 30, 50, 3, 0.9F});
  setRow(output, 2, {0, 10, 20, 30, 50, 3, 0.1F});
  const DecodedBoxes decoded = decodeEndToEnd(output, options(0));
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_EQ(decoded.boxes[0].class_id, 3);
  EXPECT_NEAR(decoded.boxes[0].score, 0.9, 1e-6);
  expectBox(decoded.boxes[0], 10, 20, 20, 30);
}

TEST(DecodeEndToEnd, TakesNoRowsForNothingFound) {
  EXPECT_TRUE(decodeEndToEnd(cv::Mat(), options(0)).boxes.empty());
  EXPECT_TRUE(decodeEndToEnd(cv::Mat(0, 7, CV_32F), options(0)).boxes.empty());
}

TEST(DecodeDarknet, ScalesSharesToTheInputAndDoesNotMultiplyTwice) {
  cv::Mat coarse(2, 7, CV_32F, cv::Scalar(0));
  cv::Mat fine(1, 7, CV_32F, cv::Scalar(0));
  setRow(coarse, 1, {0.5F, 0.25F, 0.125F, 0.5F, 0.8F, 0.0F, 0.6F});
  setRow(fine, 0, {0.5F, 0.5F, 0.25F, 0.25F, 0.5F, 0.4F, 0.0F});
  const DecodedBoxes decoded = decodeDarknet({coarse, fine}, options(2, {96, 64}));
  ASSERT_EQ(decoded.boxes.size(), 2U);
  expectBox(decoded.boxes[0], 48 - 6, 16 - 16, 12, 32);
  EXPECT_EQ(decoded.boxes[0].class_id, 1);
  EXPECT_NEAR(decoded.boxes[0].score, 0.6, 1e-6);
  EXPECT_NEAR(decoded.boxes[1].score, 0.4, 1e-6);
}

TEST(YoloDecoders, NameNetworkAndShapesWhenTheyDoNotFit) {
  const std::string text = messageOf([] { decodeYolov5(tensor({1, 9, 9}), options(80)); });
  EXPECT_THAT(text, HasSubstr("test.onnx"));
  EXPECT_THAT(text, HasSubstr("1x9x9"));
  EXPECT_THAT(text, HasSubstr("1xNx85"));
  EXPECT_THAT(messageOf([] { decodeYolov8(tensor({1, 9, 84}), options(80)); }), HasSubstr("1x84xN"));
  EXPECT_THAT(messageOf([] { decodeYolox(tensor({1, 100, 7}), options(2)); }), HasSubstr("1x84x7"));
  EXPECT_THAT(messageOf([] { decodeEndToEnd(tensor({4, 6}), options(2)); }), HasSubstr("Nx7"));
  EXPECT_THAT(messageOf([] { decodeDarknet({tensor({4, 6})}, options(2)); }), HasSubstr("Nx7"));
  EXPECT_THAT(messageOf([] { decodeYolov5(cv::Mat(1, 7, CV_8U), options(2)); }), HasSubstr("floats"));
}

TEST(YoloLayouts, AreToldFromTheShapes) {
  const auto layout = [](const std::vector<cv::Mat>& outputs) {
    return recogniseLayout(outputs, options(80, {640, 640}));
  };
  EXPECT_EQ(layout({tensor({1, 25200, 85})}), YoloLayout::kYolov5);
  EXPECT_EQ(layout({tensor({1, 8400, 85})}), YoloLayout::kYolox);
  EXPECT_EQ(layout({tensor({1, 84, 8400})}), YoloLayout::kYolov8);
  EXPECT_EQ(layout({tensor({12, 7})}), YoloLayout::kEndToEnd);
  EXPECT_EQ(layout({tensor({1, 3, 80, 80, 85}), tensor({1, 3, 40, 40, 85}), tensor({1, 3, 20, 20, 85})}),
            YoloLayout::kRawHeads);
  EXPECT_EQ(layout({tensor({1, 25200, 6})}), YoloLayout::kYolov5);
  EXPECT_EQ(layout({tensor({1, 5, 8400})}), YoloLayout::kYolov8);
  const std::string text = messageOf([&] { layout({tensor({1, 1000})}); });
  EXPECT_THAT(text, HasSubstr("test.onnx"));
  EXPECT_THAT(text, HasSubstr("1x1000"));
}

TEST(SuppressDuplicates, KeepsTheBestOfEachClass) {
  // Overlap of the first two: 8 * 10 of 10 * 10 + 10 * 10 - 80, IoU 2/3.
  std::vector<Detection> boxes = {{0, "", 0.6, {2, 0, 10, 10}},
                                  {0, "", 0.9, {0, 0, 10, 10}},
                                  {1, "", 0.5, {0, 0, 10, 10}},
                                  {0, "", 0.4, {50, 0, 10, 10}}};
  std::vector<Detection> kept = suppressDuplicates(boxes, 0.5, 10);
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_DOUBLE_EQ(kept[0].score, 0.9);
  EXPECT_DOUBLE_EQ(kept[1].score, 0.5);  // another class in the same place
  EXPECT_DOUBLE_EQ(kept[2].score, 0.4);
  EXPECT_EQ(suppressDuplicates(boxes, 0.7, 10).size(), 4U);
  EXPECT_EQ(suppressDuplicates(boxes, 0.7, 2).size(), 2U);
}

}  // namespace
}  // namespace frugal_nav
