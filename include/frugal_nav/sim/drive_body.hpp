#pragma once

#include <cstdint>
#include <string>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::sim {

/// Motors, tyres and the true size of the wheels.
struct DriveBodyParams {
  double motor_time_constant_s = 0.08;
  double max_wheel_speed_mps = 1.0;
  double max_wheel_acceleration_mps2 = 3.0;
  double slip_scale = 1.0;
  double slip_per_mps = 0.02;
  double slip_per_radps = 0.015;
  double slip_noise = 0.15;
  double slip_noise_time_s = 0.5;
  double left_radius_multiplier = 1.0;
  double right_radius_multiplier = 1.0;
  double separation_multiplier = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "motor_time_constant_s", motor_time_constant_s,
        Field{"s", "first-order lag of the wheel speed: a small geared motor under speed control", 0.0, 2.0});
    visit("max_wheel_speed_mps", max_wheel_speed_mps,
          Field{"m/s", "fastest speed of a wheel's rim; both wheels slow down together, so an arc stays one",
                0.01, 10.0});
    visit("max_wheel_acceleration_mps2", max_wheel_acceleration_mps2,
          Field{"m/s^2", "the motor's torque limit as acceleration of a wheel's rim", 0.01, 100.0});
    visit("slip_scale", slip_scale, Field{"", "scales all slip; 0 is the pure kinematics", 0.0, 20.0});
    visit("slip_per_mps", slip_per_mps,
          Field{"s/m", "share of a wheel's turning that is lost, for each m/s it rolls at", 0.0, 0.5});
    visit("slip_per_radps", slip_per_radps,
          Field{"s/rad", "share of a wheel's turning that is lost, for each rad/s the robot turns at", 0.0,
                0.5});
    visit(
        "slip_noise", slip_noise,
        Field{
            "",
            "standard deviation of a wheel's slip over its mean: moderate, as of rubber on a smooth floor; a "
            "guess, since no floor was measured",
            0.0, 2.0});
    visit("slip_noise_time_s", slip_noise_time_s,
          Field{"s", "how long a stretch of like floor lasts", 0.01, 60.0});
    visit(
        "left_radius_multiplier", left_radius_multiplier,
        Field{"", "true radius of the left wheel over the URDF's: what calibration has to find", 0.8, 1.25});
    visit("right_radius_multiplier", right_radius_multiplier,
          Field{"", "true radius of the right wheel over the URDF's", 0.8, 1.25});
    visit("separation_multiplier", separation_multiplier,
          Field{"", "true wheel separation over the URDF's", 0.8, 1.25});
  }
};

/// A differential drive on a floor: a command becomes wheel turns, and wheel turns less slip become motion.
class DriveBody {
 public:
  /// Throws ConfigError on parameters out of range.
  DriveBody(const DriveBodyParams& params, const DriveGeometry& geometry, std::uint64_t seed);

  /// What the base driver is asked for; it believes the URDF's geometry. Must be finite.
  void command(const Twist2& twist) { command_ = twist; }
  /// Advances the wheels and gives the motion of base_link along its exact arc: before_from_after.
  Pose2 step(double duration_s);
  /// Something stopped the robot after a fraction of the last step: takes the rest of the wheels' turns back,
  /// and the wheels stand. 1 keeps the step.
  void block(double fraction);

  /// Velocity over the floor of the last step, in base_link.
  const Twist2& twist() const { return twist_; }
  /// Angles the wheels have turned since the start [rad].
  double leftAngle_rad() const { return left_.angle_rad; }
  double rightAngle_rad() const { return right_.angle_rad; }

 private:
  struct Wheel {
    double true_radius_m = 0.0;
    double speed_radps = 0.0;
    double angle_rad = 0.0;
    double last_turn_rad = 0.0;
    double slip_deviation = 0.0;  ///< of the present floor, in standard deviations
    Random random;
  };

  void drive(Wheel& wheel, double target_radps, double duration_s) const;
  double groundSpeed_mps(Wheel& wheel, double turn_radps, double duration_s) const;

  DriveBodyParams params_;
  DriveGeometry geometry_;
  Twist2 command_;
  Twist2 twist_;
  Wheel left_;
  Wheel right_;
};

}  // namespace frugal_nav::sim
