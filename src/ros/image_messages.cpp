#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <frugal_nav/ros/image_messages.hpp>

namespace frugal_nav {
namespace {

namespace encodings = sensor_msgs::image_encodings;

std::string sizeText(std::size_t width_px, std::size_t height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

/// What is wrong with an image message's form; empty when its pixels can be read.
std::string formFault(const sensor_msgs::Image& msg) {
  const bool is_picture = encodings::isColor(msg.encoding) || encodings::isMono(msg.encoding) ||
                          encodings::isBayer(msg.encoding) || msg.encoding == encodings::YUV422;
  if (!is_picture) {
    return "an image of encoding \"" + msg.encoding +
           "\" is no picture: mono8, mono16, rgb8, bgr8, rgba8, bgra8, bayer or yuv422 is needed";
  }
  if (msg.width == 0 || msg.height == 0) return "the image has size " + sizeText(msg.width, msg.height);
  const std::size_t row = static_cast<std::size_t>(msg.width) *
                          static_cast<std::size_t>(encodings::numChannels(msg.encoding)) *
                          static_cast<std::size_t>(encodings::bitDepth(msg.encoding) / 8);
  if (msg.step < row) {
    return "the image's rows hold " + std::to_string(msg.step) + " bytes, but " + std::to_string(msg.width) +
           " pixels of " + msg.encoding + " need " + std::to_string(row);
  }
  const std::size_t wanted = static_cast<std::size_t>(msg.step) * msg.height;
  if (msg.data.size() != wanted) {
    return "the image holds " + std::to_string(msg.data.size()) + " bytes instead of " +
           std::to_string(wanted) + " (" + std::to_string(msg.height) + " rows of " +
           std::to_string(msg.step) + ")";
  }
  return {};
}

const char* const kCalibrate = "calibrate the camera (camera_calibration) and give its driver the file";

}  // namespace

DecodedImage decode(const sensor_msgs::ImageConstPtr& msg) {
  DecodedImage image;
  image.fault = formFault(*msg);
  if (!image.fault.empty()) return image;
  try {
    const cv_bridge::CvImageConstPtr picture = cv_bridge::toCvShare(msg, encodings::BGR8);
    image.bgr = picture->image;
    image.owner = picture;
  } catch (const std::exception& error) {  // cv_bridge's and OpenCV's have no other common base
    image.fault = "an image of encoding \"" + msg->encoding + "\" cannot be converted: " + error.what();
  }
  return image;
}

Calibration fromRos(const sensor_msgs::CameraInfo& msg) {
  Calibration out;
  const bool is_blank = std::all_of(msg.K.begin(), msg.K.end(), [](double value) { return value == 0.0; });
  if (is_blank) {
    out.fault = std::string("camera_info is all zeros: ") + kCalibrate;
    return out;
  }
  // Some drivers say 1 where they know nothing. A tenth of the width would be a lens that sees 157 degrees.
  constexpr double kLeastFocal = 0.1;
  if (msg.K[0] < kLeastFocal * msg.width || msg.K[4] < kLeastFocal * msg.height) {
    out.fault = "camera_info has a focal length of " + std::to_string(std::min(msg.K[0], msg.K[4])) +
                " pixels: " + kCalibrate;
    return out;
  }
  const auto& d = msg.D;
  const auto coefficient = [&d](std::size_t i) { return i < d.size() ? d[i] : 0.0; };
  const bool is_bent = std::any_of(d.begin(), d.end(), [](double value) { return value != 0.0; });
  const bool has_more =
      d.size() > 5 && std::any_of(d.begin() + 5, d.end(), [](double value) { return value != 0.0; });
  if (is_bent && (has_more || (msg.distortion_model != "plumb_bob" && !msg.distortion_model.empty()))) {
    out.fault = "camera_info has the distortion \"" + msg.distortion_model + "\" of " +
                std::to_string(d.size()) + " coefficients; plumb_bob with 5 is needed: " + kCalibrate;
    return out;
  }
  out.camera = {static_cast<int>(msg.width),
                static_cast<int>(msg.height),
                msg.K[0],
                msg.K[4],
                msg.K[2],
                msg.K[5],
                coefficient(0),
                coefficient(1),
                coefficient(2),
                coefficient(3),
                coefficient(4)};
  const auto& roi = msg.roi;
  if (roi.width > 0 && roi.height > 0) {
    out.camera.width_px = static_cast<int>(roi.width);
    out.camera.height_px = static_cast<int>(roi.height);
    out.camera.cx -= roi.x_offset;
    out.camera.cy -= roi.y_offset;
  }
  out.fault = out.camera.fault();
  if (!out.fault.empty()) out.fault = "camera_info: " + out.fault;
  return out;
}

Calibration fitTo(const Calibration& calibration, int width_px, int height_px) {
  if (!calibration.fault.empty()) return calibration;
  const Pinhole& camera = calibration.camera;
  // A resized image keeps its shape, to a row of rounding; a cropped one has another principal point.
  const auto rows =
      std::lround(static_cast<double>(width_px) * camera.height_px / static_cast<double>(camera.width_px));
  if (std::labs(rows - height_px) > 1) {
    return {camera, "the image is " + std::to_string(width_px) + "x" + std::to_string(height_px) +
                        ", but camera_info is for " + std::to_string(camera.width_px) + "x" +
                        std::to_string(camera.height_px) + ": " + kCalibrate};
  }
  return {camera.scaled(width_px, height_px), ""};
}

}  // namespace frugal_nav
