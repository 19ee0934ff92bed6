#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Size of a differential drive, from the URDF.
struct WheelGeometry {
  double radius_m = 0.0;
  double separation_m = 0.0;  ///< between the wheels' centres
};

/// How wheel turns become motion.
struct WheelOdometryParams {
  int ticks_per_revolution = 1440;
  int tick_bits = 64;
  double left_radius_multiplier = 1.0;
  double right_radius_multiplier = 1.0;
  double separation_multiplier = 1.0;
  double max_wheel_speed_mps = 2.5;
  double velocity_window_s = 0.1;
  double distance_noise_m = 4e-6;
  double start_x_m = 0.0;
  double start_y_m = 0.0;
  double start_yaw_rad = 0.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("ticks_per_revolution", ticks_per_revolution,
          Field{"", "encoder counts of one turn of a wheel, behind the gear", 1, 10000000});
    visit("tick_bits", tick_bits,
          Field{"", "bits after which the counts roll over: 16, 32 or 64; the simulator's never do", 16, 64});
    visit("left_radius_multiplier", left_radius_multiplier,
          Field{"", "true radius of the left wheel over the URDF's, from the square calibration", 0.5, 2.0});
    visit("right_radius_multiplier", right_radius_multiplier,
          Field{"", "true radius of the right wheel over the URDF's, from the square calibration", 0.5, 2.0});
    visit("separation_multiplier", separation_multiplier,
          Field{"", "true wheel separation over the URDF's, from the square calibration", 0.5, 2.0});
    visit("max_wheel_speed_mps", max_wheel_speed_mps,
          Field{"m/s", "a faster wheel is no motion but a restarted counter: twice what the motors reach",
                0.01, 50.0});
    visit("velocity_window_s", velocity_window_s,
          Field{"s", "span the velocity is averaged over: five readings smooth the counts' steps", 0.0, 5.0});
    visit("distance_noise_m", distance_noise_m,
          Field{"m",
                "variance of a wheel's distance per metre rolled: 2 mm after one metre, twice what the slip "
                "of the "
                "simulated floor makes, since floors differ",
                0.0, 1.0});
    visit("start_x_m", start_x_m, Field{"m", "starting pose in odom"});
    visit("start_y_m", start_y_m, Field{"m", "starting pose in odom"});
    visit("start_yaw_rad", start_yaw_rad, Field{"rad", "starting pose in odom", -M_PI, M_PI});
  }
  std::string check() const;
};

/// What wheel odometry has met besides sound readings.
struct WheelOdometryCounts {
  std::uint64_t readings = 0;    ///< used
  std::uint64_t duplicates = 0;  ///< with the stamp of the one before
  std::uint64_t rebased = 0;     ///< implausible jumps: the counter restarted; the pose stays
  std::uint64_t restarts = 0;    ///< time jumped back: from the starting pose again
  std::uint64_t refused = 0;     ///< not finite
};

/// Dead reckoning from the turns of two driven wheels, along exact arcs.
///
/// Roll-over of the counts (tick_bits) is no motion. A jump that no motor could make is a restarted counter:
/// the new counts become the base, pose and velocity stay, and the uncertainty of the unseen motion is added.
/// After a gap the motion of half a second is the most that is believed: it may be a restart as well.
/// A restart from counts so small that the jump is plausible cannot be told from motion. A stamp older than
/// the last is a jump of time: the odometry starts from its starting pose again, with no uncertainty.
class WheelOdometry {
 public:
  /// Throws ConfigError on parameters out of range or a geometry that is not positive.
  WheelOdometry(const WheelOdometryParams& params, const WheelGeometry& geometry);

  /// One reading of cumulative encoder counts. The odometry at its stamp; nullopt for a duplicate.
  std::optional<Odometry> addTicks(Stamp stamp, std::int64_t left, std::int64_t right);
  /// One reading of cumulative wheel angles [rad]. The odometry at its stamp; nullopt for a duplicate or when
  /// not finite.
  std::optional<Odometry> addAngles(Stamp stamp, double left_rad, double right_rad);

  /// Angles the wheels have turned since the start, from ticks or angles [rad].
  double leftAngle_rad() const { return left_angle_rad_; }
  double rightAngle_rad() const { return right_angle_rad_; }
  const WheelOdometryCounts& counts() const { return counts_; }

  /// Other parameters from the next reading on; the starting pose counts at the next restart only.
  /// Throws ConfigError on parameters out of range.
  void setParams(const WheelOdometryParams& params);
  /// Goes to a pose, with no uncertainty, and forgets the last reading.
  void restart(const Pose2& odom_from_base);

 private:
  struct Turn {
    double left_rad;
    double right_rad;
  };
  struct Reading {
    std::int64_t left_ticks = 0;
    std::int64_t right_ticks = 0;
    double left_rad = 0.0;
    double right_rad = 0.0;
  };
  struct Rolled {  // one entry of the velocity window: distances since the start
    Stamp stamp{};
    double left_m = 0.0;
    double right_m = 0.0;
  };

  std::optional<Odometry> add(Stamp stamp, const Reading& reading, bool is_ticks);
  Turn turnSince(const Reading& reading, bool is_ticks) const;
  bool isPlausible(const Turn& turn, double elapsed_s, bool is_ticks) const;
  void advance(double left_m, double right_m);
  void updateVelocity(Stamp stamp, double resolution_m);
  double leftRadius_m() const { return geometry_.radius_m * params_.left_radius_multiplier; }
  double rightRadius_m() const { return geometry_.radius_m * params_.right_radius_multiplier; }
  double separation_m() const { return geometry_.separation_m * params_.separation_multiplier; }

  WheelOdometryParams params_;
  WheelGeometry geometry_;
  Odometry odometry_;
  std::optional<Reading> last_;
  std::deque<Rolled> window_;
  Rolled rolled_;
  double left_angle_rad_ = 0.0;
  double right_angle_rad_ = 0.0;
  WheelOdometryCounts counts_;
};

/// Motion and its derivatives when the wheels roll two distances, starting at a heading.
struct ArcStep {
  Pose2 motion;                          ///< displacement in the frame of the heading, yaw the turn
  Eigen::Matrix3d by_pose;               ///< derivative of the new pose by the old one
  Eigen::Matrix<double, 3, 2> by_wheel;  ///< derivative of the new pose by (left, right) distance
};

/// The exact arc of two rolled distances [m], from a heading [rad].
ArcStep arcStep(double yaw_rad, double left_m, double right_m, double separation_m);

}  // namespace frugal_nav
