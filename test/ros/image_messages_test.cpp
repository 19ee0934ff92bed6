#include <limits>
#include <string>

#include <boost/make_shared.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <frugal_nav/ros/image_messages.hpp>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

/// An image of 4x2 pixels, each byte `value`.
sensor_msgs::ImagePtr imageOf(const std::string& encoding, std::uint8_t value = 100) {
  auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->width = 4;
  msg->height = 2;
  msg->encoding = encoding;
  const int pixel = sensor_msgs::image_encodings::numChannels(encoding) *
                    sensor_msgs::image_encodings::bitDepth(encoding) / 8;
  msg->step = msg->width * static_cast<std::uint32_t>(pixel);
  msg->data.assign(static_cast<std::size_t>(msg->step) * msg->height, value);
  return msg;
}

sensor_msgs::CameraInfo info() {
  sensor_msgs::CameraInfo msg;
  msg.width = 640;
  msg.height = 480;
  msg.distortion_model = "plumb_bob";
  msg.D = {0.1, -0.2, 0.001, 0.002, 0.05};
  msg.K = {532.0, 0.0, 319.5, 0.0, 531.0, 239.5, 0.0, 0.0, 1.0};
  return msg;
}

TEST(ImageMessages, GreyBecomesGreyWhateverItsDepth) {
  for (const char* encoding : {"mono8", "mono16"}) {
    const DecodedImage image = decode(imageOf(encoding));
    EXPECT_EQ(image.fault, "") << encoding;
    ASSERT_EQ(image.bgr.type(), CV_8UC3);
    // 16 bits: 100 * 257 of 65535 is 100 of 255
    EXPECT_EQ(image.bgr.at<cv::Vec3b>(1, 3), cv::Vec3b(100, 100, 100)) << encoding;
  }
}

TEST(ImageMessages, ColoursKeepTheirPlace) {
  struct Case {
    const char* encoding;
    std::vector<std::uint8_t> pixel;
  };
  for (const Case& c : {Case{"rgb8", {30, 20, 10}}, Case{"bgr8", {10, 20, 30}},
                        Case{"rgba8", {30, 20, 10, 0}}, Case{"bgra8", {10, 20, 30, 0}}}) {
    const sensor_msgs::ImagePtr msg = imageOf(c.encoding);
    for (std::size_t i = 0; i < msg->data.size(); ++i) msg->data[i] = c.pixel[i % c.pixel.size()];
    const DecodedImage image = decode(msg);
    EXPECT_EQ(image.fault, "") << c.encoding;
    EXPECT_EQ(image.bgr.at<cv::Vec3b>(0, 2), cv::Vec3b(10, 20, 30)) << c.encoding;
  }
}

TEST(ImageMessages, MosaicAndYuvAreConverted) {
  for (const char* encoding : {"bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8", "yuv422"}) {
    const DecodedImage image = decode(imageOf(encoding, 128));
    EXPECT_EQ(image.fault, "") << encoding;
    EXPECT_EQ(image.bgr.size(), cv::Size(4, 2)) << encoding;
  }
}

TEST(ImageMessages, Bgr8IsNotCopied) {
  const sensor_msgs::ImagePtr msg = imageOf("bgr8");
  const DecodedImage image = decode(msg);
  EXPECT_EQ(static_cast<const void*>(image.bgr.data), static_cast<const void*>(msg->data.data()));
}

TEST(ImageMessages, PictureOutlivesItsMessage) {
  DecodedImage image;
  {
    const sensor_msgs::ImagePtr msg = imageOf("bgr8", 77);
    image = decode(msg);
  }
  EXPECT_EQ(image.bgr.at<cv::Vec3b>(1, 1), cv::Vec3b(77, 77, 77));
}

TEST(ImageMessages, NoPictureIsAFaultThatNamesTheEncoding) {
  for (const char* encoding : {"32FC1", "16UC1", "64FC3"})
    EXPECT_THAT(decode(imageOf(encoding)).fault, HasSubstr(std::string("\"") + encoding + "\"")) << encoding;
  const sensor_msgs::ImagePtr unknown = imageOf("bgr8");
  unknown->encoding = "holograph";
  EXPECT_THAT(decode(unknown).fault, HasSubstr("holograph"));
  unknown->encoding = "";
  EXPECT_THAT(decode(unknown).fault, HasSubstr("mono8"));
}

TEST(ImageMessages, SizesThatContradictEachOtherAreFaults) {
  sensor_msgs::ImagePtr msg = imageOf("bgr8");
  msg->data.pop_back();
  EXPECT_THAT(decode(msg).fault, HasSubstr("holds 23 bytes instead of 24"));
  msg = imageOf("bgr8");
  msg->step = 11;
  EXPECT_THAT(decode(msg).fault, HasSubstr("need 12"));
  msg = imageOf("bgr8");
  msg->width = 0;
  EXPECT_THAT(decode(msg).fault, HasSubstr("size 0x2"));
  msg = imageOf("bgr8");
  msg->width = std::numeric_limits<std::uint32_t>::max();  // times 3 does not fit into 32 bits
  EXPECT_THAT(decode(msg).fault, HasSubstr("need"));
}

TEST(ImageMessages, CameraInfoBecomesAPinhole) {
  const Calibration calibration = fromRos(info());
  EXPECT_EQ(calibration.fault, "");
  EXPECT_EQ(calibration.camera.width_px, 640);
  EXPECT_EQ(calibration.camera.fy, 531.0);
  EXPECT_EQ(calibration.camera.k3, 0.05);
}

TEST(ImageMessages, BlankCameraInfoSaysWhatToDo) {
  sensor_msgs::CameraInfo blank;
  blank.width = 640;
  blank.height = 480;
  EXPECT_THAT(fromRos(blank).fault, testing::AllOf(HasSubstr("all zeros"), HasSubstr("camera_calibration")));
}

TEST(ImageMessages, PlaceholderOfADriverIsNoCalibration) {
  sensor_msgs::CameraInfo msg = info();
  msg.K[0] = msg.K[4] = 1.0;  // as image_publisher says
  EXPECT_THAT(fromRos(msg).fault, HasSubstr("camera_calibration"));
}

TEST(ImageMessages, UnusableCameraInfoIsAFault) {
  sensor_msgs::CameraInfo msg = info();
  msg.distortion_model = "equidistant";
  EXPECT_THAT(fromRos(msg).fault, HasSubstr("equidistant"));
  msg = info();
  msg.D = {0.1, 0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0};
  msg.distortion_model = "rational_polynomial";
  EXPECT_THAT(fromRos(msg).fault, HasSubstr("plumb_bob"));
  msg = info();
  msg.K[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fromRos(msg).fault, HasSubstr("focal"));
  msg = info();
  msg.width = 0;
  EXPECT_THAT(fromRos(msg).fault, HasSubstr("0x480"));
}

TEST(ImageMessages, UndistortedLensOfAnyModelIsAPinhole) {
  sensor_msgs::CameraInfo msg = info();
  msg.distortion_model = "rational_polynomial";
  msg.D.assign(8, 0.0);
  EXPECT_EQ(fromRos(msg).fault, "");
}

TEST(ImageMessages, ResizedImageScalesTheCalibration) {
  const Calibration half = fitTo(fromRos(info()), 320, 240);
  EXPECT_EQ(half.fault, "");
  EXPECT_DOUBLE_EQ(half.camera.fx, 266.0);
  EXPECT_DOUBLE_EQ(half.camera.cx, 159.5);  // the middle stays the middle
}

TEST(ImageMessages, ImageOfAnotherShapeIsAFault) {
  EXPECT_THAT(fitTo(fromRos(info()), 640, 360).fault,
              testing::AllOf(HasSubstr("640x360"), HasSubstr("640x480")));
}

TEST(ImageMessages, RegionOfInterestMovesThePrincipalPoint) {
  sensor_msgs::CameraInfo msg = info();
  msg.roi.x_offset = 160;
  msg.roi.y_offset = 120;
  msg.roi.width = 320;
  msg.roi.height = 240;
  const Calibration calibration = fitTo(fromRos(msg), 320, 240);
  EXPECT_EQ(calibration.fault, "");
  EXPECT_DOUBLE_EQ(calibration.camera.cx, 159.5);
  EXPECT_DOUBLE_EQ(calibration.camera.fx, 532.0);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
