#pragma once

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// How a robot that follows people looks for one while it has seen none.
struct SearchParams {
  bool enabled = true;
  double after_s = 4.0;
  double turn_radps = 0.3;
  double turn_rad = 6.5;
  double timeout_s = 45.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("enabled", enabled, Field{"", "turn on the spot to look for a person; false: wait for one"});
    visit("after_s", after_s,
          Field{"s", "looks ahead this long first: three images of a slow pipeline make a goal", 0.0, 600.0});
    visit("turn_radps", turn_radps,
          Field{"rad/s",
                "slow: at 1.3 images a second a head is seen four times while it passes through the view",
                0.05, 2.0});
    visit("turn_rad", turn_rad, Field{"rad", "gives up after this: a full turn and a bit", 0.1, 62.8});
    visit("timeout_s", timeout_s,
          Field{"s", "a turn that takes longer is held up; it takes 22 s", 1.0, 600.0});
  }
};

/// One turn on the spot, to the left; the collision stop stands over it.
class Search {
 public:
  enum class State { kTurning, kDone, kHeldUp };

  explicit Search(const SearchParams& params) : params_(params) {}
  void setParams(const SearchParams& params) { params_ = params; }

  /// Begins at the present pose.
  void start(const Odometry& odometry);
  /// The velocity for this instant, in base_link; zero once over.
  Twist2 update(const Odometry& odometry);
  State state() const { return state_; }

 private:
  SearchParams params_;
  State state_ = State::kDone;
  Stamp start_{};
  double last_yaw_rad_ = 0.0;
  double turned_rad_ = 0.0;
};

}  // namespace frugal_nav
