#include "drawn_face.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <opencv2/imgproc.hpp>
#include <support/message_of.hpp>
#include <support/shared_data.hpp>
#include <support/temp_folder.hpp>

#include <frugal_nav/perception/face_detectors.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav {
namespace {

using test::messageOf;
using testing::HasSubstr;

void expectTheDrawnFace(const std::vector<Detection>& faces) {
  ASSERT_EQ(faces.size(), 1U);
  EXPECT_EQ(faces[0].label, "face");
  // Detectors box a face from the brows to the chin, more or less: a fifth of its size either way.
  EXPECT_NEAR(faces[0].box.x + 0.5 * faces[0].box.width, 320, 15);
  EXPECT_NEAR(faces[0].box.y + 0.5 * faces[0].box.height, 205, 30);
  EXPECT_GT(faces[0].box.height, 90);
  EXPECT_LT(faces[0].box.height, 190);
}

TEST(CascadeFaceDetector, FindsADrawnFace) {
  const CascadeFaceParams params;
  if (messageOf([&] { CascadeFaceDetector detector(params); }).find("opencv-data") != std::string::npos) {
    GTEST_SKIP() << "package opencv-data is not installed";
  }
  CascadeFaceDetector detector(params);
  expectTheDrawnFace(detector.detect(test::drawnFace()));
  EXPECT_TRUE(detector.detect(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90))).empty());
  EXPECT_TRUE(detector.detect(cv::Mat()).empty());
  EXPECT_EQ(detector.counts().refused, 1U);
}

TEST(CascadeFaceDetector, NamesThePackageOfAMissingCascade) {
  CascadeFaceParams params;
  params.cascade_file = "no_such_cascade.xml";
  const std::string text = messageOf([&] { CascadeFaceDetector detector(params); });
  EXPECT_THAT(text, HasSubstr("no_such_cascade.xml"));
  EXPECT_THAT(text, HasSubstr("install the package opencv-data"));
}

TEST(CascadeFaceDetector, RefusesABrokenCascade) {
  const test::TempFolder folder;
  CascadeFaceParams params;
  for (const char* content :
       {"this is no cascade", "<?xml version=\"1.0\"?><opencv_storage></opencv_storage>"}) {
    params.cascade_file = folder.write("broken.xml", content);
    EXPECT_THAT(messageOf([&] { CascadeFaceDetector detector(params); }), HasSubstr("broken.xml")) << content;
  }
}

/// YuNet's outputs for a 64x32 input: 8x4, 4x2, 2x1 cells; in an order of their own.
struct YunetOutputs {
  std::vector<cv::Mat> values;

  YunetOutputs() {
    for (const int fields : {4, 1, 10, 1}) {
      for (const int cells : {8, 32, 2}) {
        const int shape[] = {1, cells, fields};
        values.emplace_back(3, shape, CV_32F, cv::Scalar(0));
      }
    }
  }
  /// The outputs of one stride that have so many fields.
  std::vector<float*> of(int cells, int fields) {
    std::vector<float*> found;
    for (cv::Mat& value : values) {
      if (value.size[1] == cells && value.size[2] == fields) found.push_back(value.ptr<float>());
    }
    return found;
  }
  void setFace(int cells, int cell, float cls, float obj, const std::vector<float>& box) {
    of(cells, 1)[0][cell] = cls;
    of(cells, 1)[1][cell] = obj;
    std::copy(box.begin(), box.end(), of(cells, 4)[0] + 4 * cell);
  }
};

const DecodeOptions kYunetOptions{"yunet.onnx", {64, 32}, 1, 0.5};

TEST(DecodeYunet, PutsTheGridOnItsThreeStrides) {
  YunetOutputs outputs;
  const float two = std::log(2.0F);
  outputs.setFace(32, 8 * 2 + 5, 0.81F, 1.0F, {0.5F, 0.25F, two, 0});  // stride 8, column 5, row 2
  outputs.setFace(2, 1, 1.0F, 0.49F, {-0.5F, 0.5F, 0, two});           // stride 32, column 1
  outputs.setFace(8, 3, 0.4F, 0.4F, {0, 0, 0, 0});                     // score 0.4
  const DecodedBoxes decoded = decodeYunet(outputs.values, kYunetOptions);
  ASSERT_EQ(decoded.boxes.size(), 2U);
  EXPECT_NEAR(decoded.boxes[0].score, 0.9, 1e-6);
  EXPECT_NEAR(decoded.boxes[0].box.x, 8 * 5.5 - 8, 1e-5);
  EXPECT_NEAR(decoded.boxes[0].box.y, 8 * 2.25 - 4, 1e-5);
  EXPECT_NEAR(decoded.boxes[0].box.width, 16, 1e-5);
  EXPECT_NEAR(decoded.boxes[0].box.height, 8, 1e-5);
  EXPECT_NEAR(decoded.boxes[1].score, 0.7, 1e-6);
  EXPECT_NEAR(decoded.boxes[1].box.x, 32 * 0.5 - 16, 1e-5);
  EXPECT_NEAR(decoded.boxes[1].box.height, 64, 1e-5);
}

TEST(DecodeYunet, DoesNotCareForTheOrderOfOutputs) {
  YunetOutputs outputs;
  outputs.setFace(32, 8 * 2 + 5, 0.81F, 1.0F, {0.5F, 0.25F, 0, 0});
  std::reverse(outputs.values.begin(), outputs.values.end());
  const DecodedBoxes decoded = decodeYunet(outputs.values, kYunetOptions);
  ASSERT_EQ(decoded.boxes.size(), 1U);
  EXPECT_NEAR(decoded.boxes[0].score, 0.9, 1e-6);
}

TEST(DecodeYunet, SkipsAndCountsBoxesThatAreNoNumbers) {
  YunetOutputs outputs;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  outputs.setFace(32, 0, 1.0F, 1.0F, {nan, 0, 0, 0});
  outputs.setFace(32, 1, nan, 1.0F, {0, 0, 0, 0});
  const DecodedBoxes decoded = decodeYunet(outputs.values, kYunetOptions);
  EXPECT_TRUE(decoded.boxes.empty());
  EXPECT_EQ(decoded.not_finite, 2U);
}

TEST(DecodeYunet, NamesNetworkAndShapesWhenAnOutputIsMissing) {
  YunetOutputs outputs;
  outputs.values.pop_back();
  const std::string text = messageOf([&] { decodeYunet(outputs.values, kYunetOptions); });
  EXPECT_THAT(text, HasSubstr("yunet.onnx"));
  EXPECT_THAT(text, HasSubstr("1x32x4"));
  EXPECT_THAT(text, HasSubstr("64x32"));
}

TEST(YunetDetector, FindsADrawnFace) {
  if (test::sharedModels().empty()) GTEST_SKIP() << "no ../shared/data/models beside the source tree";
  const auto params =
      loadParamFile<YunetParams>(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/models/yunet.yaml");
  YunetDetector detector(params, test::sharedModels());
  expectTheDrawnFace(detector.detect(test::drawnFace()));
  EXPECT_TRUE(detector.detect(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90))).empty());
}

TEST(YunetDetector, RefusesAnotherNetwork) {
  if (test::sharedModels().empty()) GTEST_SKIP() << "no ../shared/data/models beside the source tree";
  YunetParams params;
  params.model = "yolox_nano.onnx";
  params.input_width_px = params.input_height_px = 416;
  const std::string text = messageOf([&] { YunetDetector(params, test::sharedModels()); });
  EXPECT_THAT(text, HasSubstr("yolox_nano.onnx"));
  EXPECT_THAT(text, HasSubstr("1x3549x85"));
}

}  // namespace
}  // namespace frugal_nav
