#pragma once

#include <optional>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// How a person is approached, and when it counts as lost.
struct ObservedGoalParams {
  double stand_off_m = 0.8;
  double shift_m = 0.1;
  double new_approach_m = 1.0;
  double restart_m = 1.0;
  double lost_s = 8.0;
  double lost_timeout_s = 30.0;
  double view_rad = 1.082104;
  double nearest_in_view_m = 2.3;
  double farthest_in_view_m = 6.5;
  double hidden_by_m = 0.15;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("stand_off_m", stand_off_m, Field{"m", "the robot stops this far before a person", 0.0, 5.0});
    visit("shift_m", shift_m,
          Field{"m", "the goal moves when the person is seen this far from where it was", 0.0, 5.0});
    visit("new_approach_m", new_approach_m,
          Field{"m", "a person who has moved this far is approached on the line from where the robot is now",
                0.0, 20.0});
    visit("restart_m", restart_m,
          Field{"m", "once reached, a person is followed again when it has moved this far", 0.1, 50.0});
    visit("lost_s", lost_s,
          Field{"s",
                "lost when it should have been in view for this long, and was not seen; time in which it "
                "cannot be seen does not count",
                0.1, 600.0});
    visit("lost_timeout_s", lost_timeout_s,
          Field{"s", "given up after standing lost this long", 0.0, 3600.0});
    visit("view_rad", view_rad, Field{"rad", "how wide the camera sees: 62 degrees", 0.1, 3.1});
    visit("nearest_in_view_m", nearest_in_view_m,
          Field{"m", "nearer than this a standing person's head is above the image", 0.0, 20.0});
    visit("farthest_in_view_m", farthest_in_view_m,
          Field{"m", "farther than this the detector may miss it", 0.1, 100.0});
    visit("hidden_by_m", hidden_by_m,
          Field{"m",
                "where the path bends off the straight line by this, something stands there that may hide it",
                0.0, 10.0});
  }
  std::string check() const {
    return nearest_in_view_m < farthest_in_view_m ? "" : "nearest_in_view_m must be below farthest_in_view_m";
  }
};

/// A person as the goal: where to stop before it, and for how long it has not been seen though it should
/// have been. All in odom.
class ObservedGoal {
 public:
  explicit ObservedGoal(const ObservedGoalParams& params) : params_(params) {}
  void setParams(const ObservedGoalParams& params) { params_ = params; }

  /// A person seen for the first time, by a robot at that place.
  void start(const Eigen::Vector2d& p_person, const Eigen::Vector2d& p_robot, Stamp stamp);
  /// The same person seen again; true when the goal moved.
  bool see(const Eigen::Vector2d& p_person, const Eigen::Vector2d& p_robot);
  /// Where the robot is now, and how far its path bends off the straight line to its end: counts the time in
  /// which the person should be in view.
  void watch(Stamp stamp, const Pose2& odom_from_base, double bend_m);

  /// The stand-off point on the line to the person, facing it.
  Pose2 standOff() const;
  const Eigen::Vector2d& person() const { return p_person_; }
  /// Time in which it should have been in view since it was last seen [s].
  double unseen_s() const { return unseen_s_; }
  bool isLost() const { return unseen_s_ >= params_.lost_s; }

 private:
  bool shouldBeSeen(const Pose2& odom_from_base, double bend_m) const;

  ObservedGoalParams params_;
  Eigen::Vector2d p_person_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d p_approach_person_ = Eigen::Vector2d::Zero();  ///< the person when the approach was chosen
  Eigen::Vector2d approach_ = Eigen::Vector2d::UnitX();          ///< from the stand-off point to the person
  double stand_off_m_ = 0.0;                                     ///< less when the robot was nearer already
  double unseen_s_ = 0.0;
  std::optional<Stamp> watched_;
};

/// How far a path bends off the straight line between its ends [m].
double bendOf(const Path2& path);

}  // namespace frugal_nav
