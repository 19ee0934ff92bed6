#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <boost/shared_ptr.hpp>
#include <image_transport/image_transport.h>
#include <opencv2/core/mat.hpp>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Header.h>

#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/image_messages.hpp>
#include <frugal_nav/ros/intake_params.hpp>
#include <frugal_nav/ros/odometry_intake.hpp>
#include <frugal_nav/ros/sensor_poses.hpp>
#include <frugal_nav/ros/silence_watch.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// An image with all that is to be known of how it was taken; or the reason why it cannot be used.
struct CameraFrame {
  Stamp stamp{};
  std::string frame;  ///< the optical frame's name
  int width_px = 0;   ///< as the message says
  int height_px = 0;
  cv::Mat bgr;                          ///< CV_8UC3, not to be written to
  boost::shared_ptr<const void> owner;  ///< keeps the picture's memory
  Pinhole camera;                       ///< of this image's size
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
  Odometry odometry;  ///< at the stamp, where images wait for it
  std::string fault;  ///< empty: all of the above holds
};

/// Stamp and frame of what an image led to.
std_msgs::Header headerOf(const CameraFrame& frame);

/// The inputs that the image nodes share: camera/image_raw, camera/camera_info, odom.
///
/// An image is handed on, in the order of stamps, once its calibration, the camera's pose and (where wanted)
/// odometry of its stamp or later are there, and `ready` agrees; or with a fault when it is bad or has waited
/// too long: one call of `process` for each image received, whatever happens. Images are subscribed to only
/// while someone listens to what was advertised here, one at a time, without a copy inside a nodelet manager.
/// A stamp or ROS time that goes back forgets everything and calls `time_jumped`.
class ImageIntake {
 public:
  struct Callbacks {
    std::function<void(const CameraFrame&)> process;
    std::function<void()> time_jumped;
    /// May hold a sound image back; asked again at each input. Empty: never.
    std::function<bool(const CameraFrame&)> ready;
    /// Hears why no image comes, again and again; empty: it becomes the node's status.
    std::function<void(const std::string&)> silent = {};
    /// Whether images wait for the odometry of their stamp; without, odom is not subscribed to.
    bool with_odometry = true;
    /// How far stamps may go back, or lie ahead of ROS time, without a jump; see TimeJumpWatch.
    Duration slack{};
  };

  /// Throws ConfigError when there is no plugin of that image transport.
  ImageIntake(ros::NodeHandle nh, const ImageIntakeParams& params, NodeDiagnostics& diagnostics,
              Callbacks callbacks);
  ImageIntake(const ImageIntake&) = delete;  // subscriptions hold its address
  ImageIntake& operator=(const ImageIntake&) = delete;

  /// Advertises an output of the node, whose listeners keep the images coming.
  template <class Message>
  ros::Publisher advertise(const std::string& topic, std::uint32_t queue) {
    const ros::SubscriberStatusCallback changed = [this](const ros::SingleSubscriberPublisher&) {
      watchListeners();
    };
    outputs_.push_back(nh_.advertise<Message>(topic, queue, changed, changed));
    return outputs_.back();
  }

  /// Takes images from now on, whether someone listens or not.
  void stayAwake() {
    always_ = true;
    watchListeners();
  }

  /// Hands on every image that can be; to be called when what `ready` waits for has come.
  void process();
  /// Checks the stamp of a further input of the node: one that goes back is a jump in time.
  void checkStamp(const std::string& input, Stamp stamp) { time_.checkStamp(input, stamp); }
  /// How long the image handed to `ready` has waited, in ROS time [s].
  double waited_s() const;
  /// Whether a newer image waits behind the one handed to `ready`.
  bool hasNewer() const { return pending_.size() > 1; }

 private:
  struct Pending {
    CameraFrame frame;
    ros::Time since;
  };
  struct Lack {  // what a frame still needs; empty when it is complete
    std::string what;
    bool is_final = false;  // it will not come any more
  };

  void watchListeners();
  void onImage(const sensor_msgs::ImageConstPtr& msg);
  void onCameraInfo(const sensor_msgs::CameraInfo& msg);
  void onTimer();
  void forget();
  bool complete(Pending& pending);
  Lack fill(CameraFrame& frame);

  ros::NodeHandle nh_;
  ImageIntakeParams params_;
  NodeDiagnostics& diagnostics_;
  Callbacks callbacks_;
  TimeJumpWatch time_;
  SensorPoses sensors_;
  std::optional<OdometryIntake> odometry_;
  std::optional<Calibration> calibration_;
  std::deque<Pending> pending_;
  std::optional<Stamp> last_image_;
  SilenceWatch silence_;  // of the camera

  bool always_ = false;  // images are taken without listeners too
  std::vector<ros::Publisher> outputs_;
  image_transport::ImageTransport transport_;
  image_transport::Subscriber image_sub_;  // while someone listens
  ros::Subscriber info_sub_;               // likewise
  ros::Timer timer_;
};

}  // namespace frugal_nav
