#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/eval/camera_layout.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {

/// What drives a robot in one of the paper's trials: it takes ticks and images and gives velocities.
class CameraDriver {
 public:
  virtual ~CameraDriver() = default;
  CameraDriver() = default;
  CameraDriver(const CameraDriver&) = delete;
  CameraDriver& operator=(const CameraDriver&) = delete;

  virtual Twist2 addTicks(const sim::WheelTicks& ticks) = 0;
  virtual void addImage(const sim::CameraImage& image) = 0;
  /// Where its odometry says it is, in the frame of the start.
  virtual Pose2 odometry() const = 0;
  virtual bool reached() const = 0;
  /// Why it gave up; empty while it has not.
  virtual std::string abortReason() const { return ""; }
  /// What it says it is doing, for the account of a failure.
  virtual std::string activity() const { return ""; }
  /// What keeps it from getting on, in words that can be counted; empty when nothing does.
  virtual std::string trouble() const { return ""; }
  /// The last image it acted on, with what it saw there; empty when there is none.
  virtual cv::Mat lastView() const { return {}; }
  /// Its path and the obstacles it remembers, in the frame of the start.
  virtual Path2 path() const { return {}; }
  virtual std::vector<Eigen::Vector2d> remembered() const { return {}; }
};

/// What came of a trial.
struct CameraDriveRecord {
  std::string outcome;  ///< "reached", "aborted", "time_out" or "contact"
  std::string reason;   ///< of an abort; else what it was doing last
  std::string touched;  ///< what was touched first
  int contacts = 0;     ///< the robot touched something, or the walker it
  int walked_into = 0;  ///< those of the walker's making: the robot had stood for a second
  double time_s = 0.0;
  double length_m = 0.0;
  double goal_error_m = 0.0;            ///< from where it stopped to the stand-off point
  std::vector<Pose2> truth;             ///< in the world, ten a second
  std::vector<Pose2> believed;          ///< likewise
  std::vector<Eigen::Vector2d> walker;  ///< where the walker was, as often
};

/// Lets a driver drive until it is at the goal, gives up, touches something or the time is over.
CameraDriveRecord driveCamera(sim::Simulator& simulator, const CameraLayout& layout, CameraDriver& driver,
                              double speed_mps, double time_limit_s);

}  // namespace frugal_nav::eval
