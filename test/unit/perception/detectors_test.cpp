#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <support/message_of.hpp>
#include <support/shared_data.hpp>
#include <support/temp_folder.hpp>

#include <frugal_nav/perception/face_detectors.hpp>
#include <frugal_nav/perception/image_fault.hpp>
#include <frugal_nav/perception/yolo_detector.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav {
namespace {

using test::messageOf;
using test::sharedModels;
using testing::HasSubstr;

std::string configOf(const std::string& name) {
  return std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/models/" + name;
}

std::string readAll(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ImageFault, NamesWhatIsWrong) {
  EXPECT_EQ(imageFault(cv::Mat(4, 4, CV_8UC3)), "");
  EXPECT_THAT(imageFault(cv::Mat()), HasSubstr("empty"));
  EXPECT_THAT(imageFault(cv::Mat(4, 4, CV_8UC1)), HasSubstr("CV_8UC1"));
  EXPECT_THAT(imageFault(cv::Mat(4, 4, CV_32FC3)), HasSubstr("CV_32FC3"));
}

TEST(ExposureFault, TellsBlackAndSaturatedImagesFromOthers) {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(1));
  EXPECT_EQ(exposureFault(image), "the image is black");
  image.setTo(cv::Scalar::all(255));
  EXPECT_EQ(exposureFault(image), "the image is saturated");
  image(cv::Rect(0, 0, 100, 100)).setTo(cv::Scalar::all(90));
  EXPECT_EQ(exposureFault(image), "");
}

TEST(ModelFiles, AreSound) {
  for (const char* name :
       {"yolox_nano.yaml", "yolo_fastest.yaml", "yolov4.yaml", "yolov5.yaml", "yolov7.yaml", "yolov8.yaml"}) {
    EXPECT_NO_THROW(loadParamFile<YoloParams>(configOf(name))) << name;
  }
  EXPECT_NO_THROW(loadParamFile<YunetParams>(configOf("yunet.yaml")));
  EXPECT_EQ(cocoLabels().size(), 80U);
}

TEST(YoloParams, RefuseAWantedLabelThatDoesNotExist) {
  YoloParams params;
  params.labels = {"coco"};
  params.wanted = {"persn"};
  EXPECT_THAT(findFault(params), HasSubstr("persn"));
  params.wanted = {"person"};
  EXPECT_EQ(findFault(params), "");
}

TEST(YoloDetector, SaysWhatToDoAboutAMissingModel) {
  YoloParams params;
  params.model = "no_such_file.onnx";
  const std::string text = messageOf([&] { YoloDetector(params, "some_folder"); });
  EXPECT_THAT(text, HasSubstr("some_folder/no_such_file.onnx"));
  EXPECT_THAT(text, HasSubstr("put the model there"));
  params.model = "";
  EXPECT_THAT(messageOf([&] { YoloDetector detector(params); }), HasSubstr("no network file"));
}

TEST(YoloDetector, SaysWhatToDoAboutABrokenModel) {
  const test::TempFolder folder;
  YoloParams params;
  params.model = folder.write("broken.onnx", "this is no network");
  EXPECT_THAT(messageOf([&] { YoloDetector detector(params); }), HasSubstr("broken.onnx"));
  params.model = folder.write("empty.onnx", "");
  EXPECT_THAT(messageOf([&] { YoloDetector detector(params); }), HasSubstr("is empty"));
}

class RealNetworks : public testing::Test {
 protected:
  void SetUp() override {
    if (sharedModels().empty()) GTEST_SKIP() << "no ../shared/data/models beside the source tree";
    photograph_ = cv::imread(sharedModels() + "/person.jpg");
    ASSERT_FALSE(photograph_.empty());
  }
  /// The person in the photograph stands at (192..274, 99..374): measured by eye, to a few pixels.
  static void expectThePerson(const std::vector<Detection>& found) {
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].label, "person");
    EXPECT_EQ(found[0].class_id, 0);
    const cv::Rect2d person(192, 99, 82, 275);
    const double overlap = (found[0].box & person).area();
    EXPECT_GT(overlap / (found[0].box.area() + person.area() - overlap), 0.8) << found[0].box;
    EXPECT_EQ(found.size(), 1U);
  }
  cv::Mat photograph_;
};

TEST_F(RealNetworks, YoloxFindsThePerson) {
  YoloDetector detector(loadParamFile<YoloParams>(configOf("yolox_nano.yaml")), sharedModels());
  expectThePerson(detector.detect(photograph_));
  EXPECT_EQ(detector.counts().images, 1U);
}

TEST_F(RealNetworks, YoloxIsRecognisedByItsShapes) {
  YoloParams params = loadParamFile<YoloParams>(configOf("yolox_nano.yaml"));
  params.kind = "auto";
  params.wanted = {"person", "horse", "dog"};
  const std::vector<Detection> found = YoloDetector(params, sharedModels()).detect(photograph_);
  std::vector<std::string> labels;
  for (const Detection& detection : found) labels.push_back(detection.label);
  EXPECT_THAT(labels, testing::UnorderedElementsAre("person", "horse", "dog"));
}

TEST_F(RealNetworks, YoloFastestFindsThePerson) {
  YoloDetector detector(loadParamFile<YoloParams>(configOf("yolo_fastest.yaml")), sharedModels());
  expectThePerson(detector.detect(photograph_));
}

TEST_F(RealNetworks, FindThePersonInAnImageOfOddSize) {
  YoloDetector detector(loadParamFile<YoloParams>(configOf("yolox_nano.yaml")), sharedModels());
  cv::Mat odd;
  cv::resize(photograph_, odd, cv::Size(641 * 2, 427 * 2 - 1));
  const std::vector<Detection> found = detector.detect(odd);
  const std::vector<Detection> reference = detector.detect(photograph_);
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(reference.size(), 1U);
  const double sx = static_cast<double>(odd.cols) / photograph_.cols;
  // The network sees nearly the same pixels; a few per cent of the box are its own sensitivity.
  EXPECT_NEAR(found[0].box.x / sx, reference[0].box.x, 4.0);
  EXPECT_NEAR(found[0].box.width / sx, reference[0].box.width, 4.0);
}

TEST_F(RealNetworks, ImagesThatCannotBeUsedGiveNothingAndAreCounted) {
  YoloDetector detector(loadParamFile<YoloParams>(configOf("yolox_nano.yaml")), sharedModels());
  EXPECT_TRUE(detector.detect(cv::Mat()).empty());
  EXPECT_TRUE(detector.detect(cv::Mat(480, 640, CV_8UC1, cv::Scalar(0))).empty());
  EXPECT_TRUE(detector.detect(cv::Mat(480, 640, CV_32FC3, cv::Scalar::all(0))).empty());
  EXPECT_EQ(detector.counts().refused, 3U);
  EXPECT_TRUE(detector.detect(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0))).empty());
  EXPECT_TRUE(detector.detect(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(0))).empty());
  EXPECT_EQ(detector.counts().images, 2U);
  expectThePerson(detector.detect(photograph_));
}

TEST_F(RealNetworks, AWrongKindNamesNetworkAndShapes) {
  YoloParams params = loadParamFile<YoloParams>(configOf("yolox_nano.yaml"));
  params.kind = "yolov8";
  const std::string text = messageOf([&] { YoloDetector(params, sharedModels()); });
  EXPECT_THAT(text, HasSubstr("yolox_nano.onnx"));
  EXPECT_THAT(text, HasSubstr("1x3549x85"));
  EXPECT_THAT(text, HasSubstr("1x84xN"));
  params.kind = "yolox";
  params.labels = {"head"};
  params.wanted = {};
  EXPECT_THAT(messageOf([&] { YoloDetector(params, sharedModels()); }), HasSubstr("1x3549x6"));
}

TEST_F(RealNetworks, HalfADownloadIsRefused) {
  const test::TempFolder folder;
  const std::string model = readAll(sharedModels() + "/yolox_nano.onnx");
  YoloParams params = loadParamFile<YoloParams>(configOf("yolox_nano.yaml"));
  params.model = folder.write("half.onnx", model.substr(0, model.size() / 2));
  EXPECT_THAT(messageOf([&] { YoloDetector detector(params); }), HasSubstr("half.onnx"));

  params = loadParamFile<YoloParams>(configOf("yolo_fastest.yaml"));
  const std::string weights = readAll(sharedModels() + "/yolo-fastest-1.1.weights");
  params.model = sharedModels() + "/yolo-fastest-1.1.cfg";
  params.weights = folder.write("half.weights", weights.substr(0, weights.size() / 2));
  EXPECT_THAT(messageOf([&] { YoloDetector detector(params); }), HasSubstr("half.weights"));
}

}  // namespace
}  // namespace frugal_nav
