#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/control/path_follower.hpp>
#include <frugal_nav/control/velocity_limiter.hpp>
#include <frugal_nav/planning/camera_planner.hpp>

namespace frugal_nav::test {

/// frugal_bot's: 0.25 m wide, its tail 0.16 m behind base_link.
constexpr BodyExtent kCourseBody{0.125, 0.203};

/// A person who walks straight on, seen from above.
struct Walker {
  Eigen::Vector2d start;
  Eigen::Vector2d velocity_mps;
  double start_s = 0.0;  ///< stands there before
  double radius_m = 0.25;

  Eigen::Vector2d at(double time_s) const { return start + std::max(0.0, time_s - start_s) * velocity_mps; }
};

/// A flat world to drive through: convex obstacles, walkers, and the person who is the goal.
struct Course {
  std::vector<Polygon2> obstacles;  ///< counter-clockwise
  std::vector<Walker> walkers;
  Pose2 start;
  Eigen::Vector2d person;
  double person_radius_m = 0.22;
  double stand_off_m = 0.8;

  Course& box(double x, double y, double size_x, double size_y, double yaw = 0.0) {
    const Pose2 pose{x, y, yaw};
    obstacles.push_back(
        {pose * Eigen::Vector2d(-size_x / 2, -size_y / 2), pose * Eigen::Vector2d(size_x / 2, -size_y / 2),
         pose * Eigen::Vector2d(size_x / 2, size_y / 2), pose * Eigen::Vector2d(-size_x / 2, size_y / 2)});
    return *this;
  }
  /// Where the robot should stop: before the person, on the line from the start.
  Eigen::Vector2d standOff(const Eigen::Vector2d& p_person) const {
    return p_person + stand_off_m * (start.position() - p_person).normalized();
  }
};

/// How it is driven.
struct CourseRun {
  double speed_mps = 0.25;
  double rate_hz = 5.0;
  double latency_s = 0.15;
  double view_rad = 62.0 / 180.0 * M_PI;
  double range_sigma_m = 0.03;       ///< of each ray
  double range_sigma_share = 0.01;   ///< likewise, of its range
  double scale_sigma = 0.03;         ///< of all rays of an image together
  double person_sigma_share = 0.04;  ///< of the person's distance
  std::uint64_t seed = 1;
  CameraPlannerParams planner;
  PathFollowerParams follower;
  VelocityLimits limits;
  std::function<void(double time_s, const Pose2& pose, const CameraPlan& plan)> watch;
};

/// What came of it.
struct CourseResult {
  bool reached = false;
  bool touched = false;   ///< drove into something
  bool run_into = false;  ///< was run into: by a walker faster toward it than it was toward the walker
  bool unseen = false;    ///< by one that was in view for less than half a second of the last three
  std::string what;
  double time_s = 0.0;
  double goal_error_m = 0.0;
  double clearance_m = std::numeric_limits<double>::infinity();  ///< smallest, to standing things
  std::string last_reason;

  bool ok() const { return reached && !touched && !run_into; }
};

/// Drives the planner and the path follower through a course: two-dimensional ray casting with noise in the
/// place of a camera, accelerations and motor lag in the place of the base.
class CourseDrive {
 public:
  CourseDrive(const Course& course, const CourseRun& run)
      : course_(course),
        run_(run),
        random_(run.seed),
        planner_(tuned(run), kCourseBody),
        follower_(tuned(run.follower, run.speed_mps)),
        limiter_(run.limits, 0.21),
        pose_(course.start),
        slip_(random_.normal(0.005)),
        turn_slip_(random_.normal(0.01)) {
    person_error_ = random_.normal(1.0);
  }

  CourseResult drive() {
    const double limit_s = 3.0 * (course_.person - course_.start.position()).norm() / run_.speed_mps + 20.0;
    double next_image_s = 0.0;
    double still_s = 0.0;
    for (int step = 0; step * kStep_s < limit_s; ++step) {
      const double now_s = step * kStep_s;
      result_.time_s = now_s;
      if (now_s >= next_image_s) {
        look(now_s);
        next_image_s += 1.0 / run_.rate_hz;
      }
      while (!answers_.empty() && answers_.front().at_s <= now_s) {
        path_ = answers_.front().path;
        answers_.pop_front();
      }
      if (step % 3 == 0) control(now_s);
      move();
      touch(now_s);
      result_.goal_error_m = (pose_.position() - course_.standOff(course_.person)).norm();
      if (result_.touched || result_.run_into) return result_;
      const double to_goal_m = goal_ ? (odom_.position() - goal_->position()).norm() : 1e9;
      still_s = to_goal_m < 0.1 && twist_.v_mps < 0.02 ? still_s + kStep_s : 0.0;
      if (still_s > 0.5 || to_goal_m < 0.05) {
        result_.reached = result_.goal_error_m <= 0.30;
        if (!result_.reached) result_.what = "stopped elsewhere";
        return result_;
      }
    }
    result_.what = "time-out";
    return result_;
  }

  const CameraPlanner& planner() const { return planner_; }

 private:
  static constexpr double kStep_s = 0.0166667;
  struct Answer {
    double at_s;
    Path2 path;
  };

  static CameraPlannerParams tuned(const CourseRun& run) {
    CameraPlannerParams params = run.planner;
    params.right_of_way.cruise_mps = run.speed_mps;
    return params;
  }
  static PathFollowerParams tuned(PathFollowerParams params, double speed_mps) {
    params.cruise_mps = speed_mps;
    return params;
  }

  /// Distance along a ray to the first thing; the person last, told apart by `is_person`.
  double rangeOf(double yaw_rad, double now_s, bool& is_person) const {
    const Eigen::Vector2d d(std::cos(yaw_rad), std::sin(yaw_rad));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Polygon2& shape : course_.obstacles) {
      for (std::size_t i = 0; i < shape.size(); ++i) {
        const Eigen::Vector2d line = shape[(i + 1) % shape.size()] - shape[i];
        const double determinant = d.y() * line.x() - d.x() * line.y();
        if (std::abs(determinant) < 1e-12) continue;
        const Eigen::Vector2d to = shape[i] - pose_.position();
        const double range = (to.y() * line.x() - to.x() * line.y()) / determinant;
        const double along = (d.x() * to.y() - d.y() * to.x()) / determinant;
        if (range >= 0.0 && along >= 0.0 && along <= 1.0) nearest = std::min(nearest, range);
      }
    }
    const auto circle = [&](const Eigen::Vector2d& center, double radius) {
      const Eigen::Vector2d to = center - pose_.position();
      const double along = to.dot(d);
      const double squared = radius * radius - (to.squaredNorm() - along * along);
      return squared < 0.0 || along < 0.0 ? std::numeric_limits<double>::infinity()
                                          : along - std::sqrt(squared);
    };
    for (const Walker& walker : course_.walkers)
      nearest = std::min(nearest, circle(walker.at(now_s), walker.radius_m));
    const double to_person = circle(course_.person, course_.person_radius_m);
    is_person = to_person < nearest;
    return std::min(nearest, to_person);
  }

  CameraObservation observe(double now_s) {
    constexpr std::size_t kBeams = 120;
    constexpr double kLongest_m = 6.0;
    CameraObservation seen;
    seen.stamp = stampFromSeconds(100.0 + now_s);
    seen.odometry.stamp = seen.stamp;
    seen.odometry.odom_from_base = odom_;
    seen.odometry.twist = twist_;
    seen.scan.stamp = seen.stamp;
    seen.scan.angle_min_rad = -0.5 * run_.view_rad;
    seen.scan.angle_increment_rad = run_.view_rad / (kBeams - 1);
    seen.scan.range_min_m = 0.05;
    seen.scan.range_max_m = kLongest_m;
    const double scale = 1.0 + random_.normal(run_.scale_sigma);
    double nearest_m = std::numeric_limits<double>::infinity();
    std::vector<double> depths;
    for (std::size_t i = 0; i < kBeams; ++i) {
      bool is_person = false;
      const double bearing = seen.scan.angleOf(i);
      const double truth = rangeOf(pose_.yaw_rad + bearing, now_s, is_person);
      const double noise =
          random_.normal(run_.range_sigma_m) + truth * random_.normal(run_.range_sigma_share);
      const double range = std::isinf(truth) ? truth : std::max(0.06, scale * truth + noise);
      seen.scan.ranges_m.push_back(
          static_cast<float>(range > kLongest_m ? std::numeric_limits<double>::infinity() : range));
      depths.push_back(std::min(range, kLongest_m));
      if (is_person || range > kLongest_m || range >= nearest_m) continue;
      nearest_m = range;
      seen.obstacle.found = true;
      seen.obstacle.p_odom = odom_ * Eigen::Vector2d(range * std::cos(bearing), range * std::sin(bearing));
      seen.obstacle.distance_m = range;
      seen.obstacle.bearing_rad = bearing;
      seen.obstacle.sigma_m = 0.03 + 0.03 * range;
      seen.obstacle.source = "floor";
    }
    seen.obstacle.stamp = seen.gap.stamp = seen.stamp;
    findGap(seen, depths);
    return seen;
  }

  /// The paper's gap: the longest run of columns farther than the mean.
  static void findGap(CameraObservation& seen, const std::vector<double>& depths) {
    double mean = 0.0;
    for (const double depth : depths) mean += depth / static_cast<double>(depths.size());
    std::size_t best_first = 0, best_count = 0;
    for (std::size_t i = 0, count = 0; i < depths.size(); ++i) {
      count = depths[i] > mean && depths[i] > 1.0 ? count + 1 : 0;
      if (count > best_count) {
        best_count = count;
        best_first = i + 1 - count;
      }
    }
    seen.gap.found = best_count > 2;
    if (!seen.gap.found) {
      seen.gap.reason = "everything in view is near";
      return;
    }
    const std::size_t last = best_first + best_count - 1;
    seen.gap.right_bearing_rad = seen.scan.angleOf(best_first);
    seen.gap.left_bearing_rad = seen.scan.angleOf(last);
    seen.gap.bearing_rad = 0.5 * (seen.gap.left_bearing_rad + seen.gap.right_bearing_rad);
    double bound = std::numeric_limits<double>::infinity();
    if (best_first > 0) bound = std::min(bound, depths[best_first - 1]);
    if (last + 1 < depths.size()) bound = std::min(bound, depths[last + 1]);
    if (std::isinf(bound)) bound = 1.5;
    seen.gap.depth_m = bound;
    seen.gap.width_m = bound * (std::tan(seen.gap.left_bearing_rad) - std::tan(seen.gap.right_bearing_rad));
    seen.gap.p_odom = seen.odometry.odom_from_base * Eigen::Vector2d(bound * std::cos(seen.gap.bearing_rad),
                                                                     bound * std::sin(seen.gap.bearing_rad));
  }

  void look(double now_s) {
    const CameraObservation seen = observe(now_s);
    followPerson();
    planner_.setGoal(goal_, person_);
    const CameraPlan plan = planner_.update(seen);
    result_.last_reason = plan.reason;
    if (run_.watch) run_.watch(now_s, pose_, plan);
    answers_.push_back({now_s + run_.latency_s, plan.path});
  }

  /// The person as a tracker gives it: distance known to a share, slowly getting better, in odom.
  void followPerson() {
    person_error_ = 0.95 * person_error_ + random_.normal(0.3);
    const Eigen::Vector2d way = course_.person - pose_.position();
    const Eigen::Vector2d seen =
        odom_ *
        (pose_.inverse() * Eigen::Vector2d(course_.person + run_.person_sigma_share * person_error_ * way));
    const bool in_view =
        std::abs(bearingTo(pose_, course_.person)) < 0.45 * run_.view_rad && way.norm() > 2.0;
    if (person_ && !in_view) return;
    if (person_ && (*person_ - seen).norm() < 0.1) return;
    person_ = seen;
    const Eigen::Vector2d stand = course_.standOff(*person_);
    goal_ = Pose2{stand.x(), stand.y(), 0.0};
  }

  void control(double now_s) {
    const Stamp stamp = stampFromSeconds(100.0 + now_s);
    const Twist2 wanted =
        path_.empty() ? Twist2{} : limiter_.limitSpeed(follower_.command(path_, odom_, stamp));
    command_ = limiter_.limitAcceleration(wanted, command_, 3 * kStep_s);
  }

  void move() {
    constexpr double kLag_s = 0.08;
    twist_.v_mps += kStep_s / kLag_s * (command_.v_mps - twist_.v_mps);
    twist_.w_radps += kStep_s / kLag_s * (command_.w_radps - twist_.w_radps);
    pose_ = pose_ * arcMotion(twist_, kStep_s);
    const Twist2 felt{twist_.v_mps * (1.0 + slip_), twist_.w_radps * (1.0 + turn_slip_)};
    odom_ = odom_ * arcMotion(felt, kStep_s);
  }

  static double distanceTo(const Polygon2& a, const Polygon2& b) {
    double gap = -std::numeric_limits<double>::infinity();
    for (const auto* pair : {&a, &b}) {
      const Polygon2& other = pair == &a ? b : a;
      for (std::size_t i = 0; i < pair->size(); ++i) {
        const Eigen::Vector2d along = ((*pair)[(i + 1) % pair->size()] - (*pair)[i]).normalized();
        const Eigen::Vector2d outward(along.y(), -along.x());
        double nearest = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector2d& p : other) nearest = std::min(nearest, outward.dot(p - (*pair)[i]));
        gap = std::max(gap, nearest);
      }
    }
    return gap;  // exact where an edge faces; a little less beside two corners
  }

  void touch(double now_s) {
    const Polygon2 body{pose_ * Eigen::Vector2d(-0.16, -0.125), pose_ * Eigen::Vector2d(0.12, -0.125),
                        pose_ * Eigen::Vector2d(0.12, 0.125), pose_ * Eigen::Vector2d(-0.16, 0.125)};
    for (const Polygon2& shape : course_.obstacles) {
      const double gap = distanceTo(body, shape);
      result_.clearance_m = std::min(result_.clearance_m, gap);
      if (gap < 0.0) {
        result_.touched = true;
        result_.what = "obstacle";
      }
    }
    for (const Walker& walker : course_.walkers) {
      in_view_.push_back(std::abs(bearingTo(pose_, walker.at(now_s))) < 0.5 * run_.view_rad);
      if (static_cast<double>(in_view_.size()) * kStep_s > 3.0) in_view_.pop_front();
      const Eigen::Vector2d p = pose_.inverse() * walker.at(now_s);
      const double dx = std::max({-0.16 - p.x(), p.x() - 0.12, 0.0});
      const double dy = std::max(std::abs(p.y()) - 0.125, 0.0);
      if (std::hypot(dx, dy) >= walker.radius_m) continue;
      result_.what = "walker";
      const Eigen::Vector2d toward = (walker.at(now_s) - pose_.position()).normalized();
      const Eigen::Vector2d walking = (walker.at(now_s) - walker.at(now_s - 0.1)) / 0.1;
      const double driven =
          twist_.v_mps * Eigen::Vector2d(std::cos(pose_.yaw_rad), std::sin(pose_.yaw_rad)).dot(toward);
      (driven > -walking.dot(toward) ? result_.touched : result_.run_into) = true;
      const auto in_view = std::count(in_view_.begin(), in_view_.end(), true);
      result_.unseen = static_cast<double>(in_view) * kStep_s < 0.5;
    }
  }

  Course course_;
  CourseRun run_;
  Random random_;
  CameraPlanner planner_;
  PathFollower follower_;
  VelocityLimiter limiter_;
  Pose2 pose_;
  double slip_;
  double turn_slip_;
  Pose2 odom_ = pose_;
  Twist2 twist_;
  Twist2 command_;
  Path2 path_;
  std::deque<Answer> answers_;
  std::optional<Pose2> goal_;
  std::optional<Eigen::Vector2d> person_;
  double person_error_ = 0.0;
  std::deque<bool> in_view_;  ///< whether a walker was, step by step
  CourseResult result_;
};

/// A layout as the success suite draws them: a person 4 to 7 m away, one obstacle on the straight line, up to
/// two beside it with gaps of 1.5 to 4 robot widths, walls around, and with `with_walker` someone who
/// crosses.
inline Course randomCourse(std::uint64_t seed, bool with_walker, double speed_mps) {
  Random random(seed, "course");
  Course course;
  const double distance = random.uniform(4.0, 7.0);
  course.person = {distance, random.uniform(-0.3, 0.3)};
  course.start = {0.0, 0.0, random.uniform(-0.3, 0.3)};
  const double half = random.uniform(1.8, 3.0);
  course.box(distance / 2, half + 0.05, distance + 4.0, 0.1)
      .box(distance / 2, -half - 0.05, distance + 4.0, 0.1);
  course.box(distance + 1.5, 0.0, 0.1, 2.0 * half).box(-1.5, 0.0, 0.1, 2.0 * half);
  const double x = random.uniform(1.3, distance - 2.0);
  const double width = random.uniform(0.2, 1.0);
  const double y = random.uniform(-0.35, 0.35) * width + course.person.y() * x / distance;
  course.box(x, y, random.uniform(0.2, 0.5), width);
  const int more = random.integer(0, 2);
  for (int i = 0; i < more; ++i) {
    const double side = i == 0 ? (random.chance(0.5) ? 1.0 : -1.0) : (random.chance(0.5) ? 1.0 : -1.0);
    const double gap = 0.25 * random.uniform(1.5, 4.0);
    const double other = random.uniform(0.2, 1.0);
    const double dx = i == 0 ? random.uniform(-0.4, 0.4) : random.uniform(0.6, 1.4);
    if (x + dx > distance - 1.6) continue;
    course.box(x + dx, y + side * (width / 2 + gap + other / 2), random.uniform(0.2, 0.5), other);
  }
  if (with_walker) {
    Walker walker;
    const double speed = random.uniform(0.3, 1.0);
    const double side = random.chance(0.5) ? 1.0 : -1.0;
    const double crossing_x = random.uniform(1.2, distance - 1.5);
    const double from = half - 0.3;
    const double slant = random.uniform(-0.3, 0.3);
    walker.start = {crossing_x - slant * from, side * from};
    walker.velocity_mps = speed * Eigen::Vector2d(slant, -side).normalized();
    // He crosses ahead: one who would meet the robot just there comes from farther aside than it sees.
    const double there_s = (crossing_x - random.uniform(0.5, 3.0)) / speed_mps;
    const double late_s = std::max(0.0, from / speed - there_s);  // then he has begun before the robot
    walker.start += late_s * walker.velocity_mps;
    walker.start_s = std::max(0.0, there_s - from / speed);
    course.walkers.push_back(walker);
  }
  return course;
}

/// A wall across the room whose only opening is `gap_m` wide; thick as a shelf, or two obstacles that stand
/// not quite in line.
inline Course gateCourse(std::uint64_t seed, double gap_m) {
  Random random(seed, "gate");
  Course course;
  const double distance = random.uniform(4.0, 6.0);
  course.person = {distance, random.uniform(-0.3, 0.3)};
  course.start = {0.0, 0.0, random.uniform(-0.3, 0.3)};
  constexpr double kHalf_m = 1.8;
  course.box(distance / 2, kHalf_m + 0.05, distance + 4.0, 0.1);
  course.box(distance / 2, -kHalf_m - 0.05, distance + 4.0, 0.1);
  course.box(distance + 1.5, 0.0, 0.1, 2.0 * kHalf_m).box(-1.5, 0.0, 0.1, 2.0 * kHalf_m);
  const double x = random.uniform(1.5, distance - 2.0);
  const double middle = random.uniform(-0.8, 0.8);
  for (const double side : {-1.0, 1.0}) {
    const double edge = middle + side * gap_m / 2;
    const double beyond = side * kHalf_m;
    course.box(x + random.uniform(-0.1, 0.1), (edge + beyond) / 2, random.uniform(0.2, 0.5),
               std::abs(beyond - edge));
  }
  return course;
}

}  // namespace frugal_nav::test
