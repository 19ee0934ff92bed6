#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Noise of the motion that the wheels' twist tells; "per root" values are densities, so that the uncertainty
/// does not depend on the rate of the input.
struct TwistNoiseParams {
  double distance_noise = 0.0035;
  double speed_noise = 0.002;
  double turn_noise = 0.05;
  double veer_noise = 0.03;
  double rate_noise = 0.005;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "distance_noise", distance_noise,
        Field{"m/sqrt(m)",
              "of the distance, a root metre driven: 3.5 mm after one metre of calibrated wheels", 0.0, 5.0});
    visit("speed_noise", speed_noise,
          Field{"m/sqrt(s)", "of the distance, a root second moving: jerks at low speed", 0.0, 5.0});
    visit("turn_noise", turn_noise,
          Field{"rad/sqrt(rad)", "of the heading, a root radian turned; without a gyro only", 0.0, 5.0});
    visit("veer_noise", veer_noise,
          Field{"rad/sqrt(m)", "of the heading, a root metre driven; without a gyro only", 0.0, 5.0});
    visit("rate_noise", rate_noise,
          Field{"rad/sqrt(s)", "of the heading, a root second moving; without a gyro only", 0.0, 5.0});
  }
};

/// The Kalman filter of pose and sensor biases.
struct PoseFilterParams {
  std::string twist_source = "encoders";
  TwistNoiseParams twist;
  double gyro_noise = 0.00045;
  double gyro_bias_sigma_radps = 0.02;
  double gyro_bias_walk = 1e-4;
  bool estimate_scale = false;
  double scale_sigma = 0.05;
  double scale_walk = 1e-3;
  bool estimate_rate_bias = false;
  double rate_bias_sigma_radps = 0.02;
  double rate_bias_walk = 1e-3;
  double still_speed_mps = 0.002;
  double still_rate_radps = 0.01;
  double still_gyro_radps = 0.1;
  double still_time_s = 0.3;
  double still_noise = 1e-4;
  double input_timeout_s = 0.25;
  double lost_speed_noise = 0.5;
  double lost_turn_noise = 0.5;
  double gate_probability = 0.999;
  int restart_after_gated = 15;
  double restart_after_s = 2.0;
  double history_s = 2.0;
  double future_tolerance_s = 0.1;
  double jump_back_s = 0.1;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("twist_source", twist_source,
          atStart(Field{"", "whose speed moves the pose; command: for a base without encoders", -1e9, 1e9,
                        "encoders|command"}));
    visit("twist", twist);
    visit("gyro_noise", gyro_noise,
          Field{"rad/sqrt(s)", "white noise of the gyro's angle: a cheap MEMS gyro with its mounting", 1e-6,
                1.0});
    visit("gyro_bias_sigma_radps", gyro_bias_sigma_radps,
          atStart(Field{"rad/s", "of the gyro's bias at switch-on: 1 degree/s is a MEMS gyro's", 0.0, 1.0}));
    visit(
        "gyro_bias_walk", gyro_bias_walk,
        Field{"rad/s/sqrt(s)", "how the gyro's bias wanders: warming up, 0.3 degree/s in an hour", 0.0, 0.1});
    visit("estimate_scale", estimate_scale,
          atStart(Field{"", "true speed over told speed is a state: for wheels whose size is not known"}));
    visit("scale_sigma", scale_sigma, atStart(Field{"", "of the scale at the start", 0.0, 1.0}));
    visit("scale_walk", scale_walk, Field{"1/sqrt(s)", "how the scale wanders: floors differ", 0.0, 1.0});
    visit("estimate_rate_bias", estimate_rate_bias,
          atStart(
              Field{"", "offset of the twist's yaw rate is a state: for a base that veers, without a gyro"}));
    visit("rate_bias_sigma_radps", rate_bias_sigma_radps,
          atStart(Field{"rad/s", "of the twist's yaw rate offset at the start", 0.0, 1.0}));
    visit("rate_bias_walk", rate_bias_walk,
          Field{"rad/s/sqrt(s)", "how the yaw rate offset wanders", 0.0, 1.0});
    visit("still_speed_mps", still_speed_mps,
          Field{"m/s", "below it and still_rate_radps the wheels stand", 0.0, 0.1});
    visit("still_rate_radps", still_rate_radps, Field{"rad/s", "see still_speed_mps", 0.0, 0.5});
    visit("still_gyro_radps", still_gyro_radps,
          Field{"rad/s", "a gyro that says more, its bias taken off, means that the robot is being turned",
                0.0, 1.0});
    visit("still_time_s", still_time_s,
          Field{"s", "the wheels have stood this long before the body is believed to stand", 0.0, 10.0});
    visit("still_noise", still_noise,
          Field{"m/sqrt(s)",
                "of position [m] and heading [rad] while standing, though nothing moves: images of one view "
                "err alike, and those of an hour are worth no more than some ten seconds'",
                0.0, 0.1});
    visit(
        "input_timeout_s", input_timeout_s,
        Field{"s", "an older twist or gyro is not believed any more: the filter goes on without", 0.02, 5.0});
    visit("lost_speed_noise", lost_speed_noise,
          Field{"m/sqrt(s)", "of the position, each way, without a twist: the robot's speed", 0.0, 10.0});
    visit("lost_turn_noise", lost_turn_noise,
          Field{"rad/sqrt(s)", "of the heading without gyro and twist: a gentle turn", 0.0, 10.0});
    visit(
        "gate_probability", gate_probability,
        Field{"", "share of sound measurements that pass the chi-square gate; 1 switches it off", 0.5, 1.0});
    visit("restart_after_gated", restart_after_gated,
          Field{"",
                "so many poses refused in a row that agree with each other: the filter, not they, is wrong, "
                "and starts from the last; 0: never",
                0, 10000});
    visit("restart_after_s", restart_after_s,
          Field{"s", "and for so long: a marker that was moved may be seen alone for a moment", 0.0, 600.0});
    visit("history_s", history_s,
          Field{"s", "how late a measurement may come: exposure, transport and detection of an image", 0.1,
                60.0});
    visit("future_tolerance_s", future_tolerance_s,
          Field{"s",
                "a stamp farther after its reception is refused: clocks are not synchronous; "
                "marker_localization: "
                "at least 1 s in simulated time, which lags behind the sensors",
                0.0, 10.0});
    visit("jump_back_s", jump_back_s,
          Field{"s", "the time of reception goes back by more: time jumped, the filter starts anew", 0.0,
                10.0});
  }
};

}  // namespace frugal_nav
