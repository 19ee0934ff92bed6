#include "person_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/people.hpp>

namespace frugal_nav::sim {
namespace {

/// Angles of one leg in the vertical plane ahead [rad]; forward is positive, 0 hangs down.
struct LegAngles {
  double thigh = 0.0;
  double shin = 0.0;
};

/// All angles of a body [rad] and where its hips are, in the person's frame [m].
struct Figure {
  double hip_x_m = 0.0;
  double hip_z_m = 0.0;
  double lean = 0.0;
  std::array<LegAngles, 2> legs;
  std::array<double, 2> foot_pitch{};  ///< toes up is positive
  std::array<double, 2> upper_arm{};   ///< forward
  std::array<double, 2> elbow{};
  double arms_out = 0.10;
};

/// The leg that brings the ankle to a point ahead of and below the hip: two links, the knee bending forward.
LegAngles reach(const PersonBody& body, double ahead_m, double below_m) {
  const double t = body.thigh_m;
  const double s = body.shin_m;
  const double d = std::clamp(std::hypot(ahead_m, below_m), std::abs(t - s) + 1e-6, t + s - 1e-6);
  const double line = std::atan2(ahead_m, below_m);
  const double at_hip = std::acos(std::clamp((t * t + d * d - s * s) / (2.0 * t * d), -1.0, 1.0));
  const double at_knee = std::acos(std::clamp((t * t + s * s - d * d) / (2.0 * t * s), -1.0, 1.0));
  LegAngles leg;
  leg.thigh = line + at_hip;
  leg.shin = leg.thigh - (M_PI - at_knee);
  return leg;
}

Figure standing(const PersonBody& body, std::uint64_t appearance) {
  Random random(appearance, "person stance");
  Figure figure;
  figure.hip_z_m = 0.998 * body.hip_height_m;
  for (std::size_t side = 0; side < 2; ++side) {
    figure.legs[side] = reach(body, random.uniform(-0.03, 0.03), figure.hip_z_m - body.ankle_m);
    figure.upper_arm[side] = random.uniform(-0.08, 0.12);
    figure.elbow[side] = random.chance(0.25) ? random.uniform(1.1, 1.5) : random.uniform(0.12, 0.35);
  }
  return figure;
}

Figure sitting(const PersonBody& body) {
  constexpr double kThighRadius_m = 0.075;
  constexpr double kHipsBehindMiddle_m = 0.06;
  Figure figure;
  figure.hip_x_m = -kHipsBehindMiddle_m;
  figure.hip_z_m = kSeatHeight_m + kThighRadius_m;
  figure.lean = 0.03;
  const double knee_rise =
      std::clamp((body.shin_m + body.ankle_m - figure.hip_z_m) / body.thigh_m, -0.9, 0.9);
  for (std::size_t side = 0; side < 2; ++side) {
    figure.legs[side] = {0.5 * M_PI + std::asin(knee_rise), 0.0};  // shins upright, soles on the floor
    figure.upper_arm[side] = 0.08;                                 // hands on the thighs, below any table
    figure.elbow[side] = 1.12;
  }
  return figure;
}

/// A step cycle of the distance walked: a foot stands still on the floor for one half of it and swings
/// forward in the other.
Figure walking(const PersonBody& body, double walked_m) {
  const double leg = body.thigh_m + body.shin_m;
  const double stride = 1.5 * leg;
  constexpr double kSwingLift_m = 0.09;
  Figure figure;
  const auto phaseOf = [&](std::size_t side) {
    // A quarter cycle into its stand the foot passes below the hips: both legs are closest at no distance.
    const double cycle = walked_m / stride + 0.25 + 0.5 * static_cast<double>(side);
    return cycle - std::floor(cycle);
  };
  // The hips swing over the standing leg, which stays nearly straight.
  const double standing_ahead = stride * (0.25 - std::min(phaseOf(0), phaseOf(1)));
  figure.hip_z_m = body.ankle_m + 0.99 * std::sqrt(leg * leg - standing_ahead * standing_ahead);
  figure.lean = 0.04;
  for (std::size_t side = 0; side < 2; ++side) {
    const double phase = phaseOf(side);
    double ahead = stride * (0.25 - phase);
    double lift = 0.0;
    if (phase > 0.5) {
      const double swing = 2.0 * phase - 1.0;
      ahead = stride * 0.25 * -std::cos(M_PI * swing);
      lift = kSwingLift_m * std::sin(M_PI * swing);
      figure.foot_pitch[side] = -0.5 * std::sin(M_PI * std::min(1.0, 1.5 * swing));
    }
    figure.legs[side] = reach(body, ahead, figure.hip_z_m - body.ankle_m - lift);
    const double swing_arm = ahead / (0.25 * stride);
    figure.upper_arm[side] = -0.40 * swing_arm;
    figure.elbow[side] = 0.35 + 0.15 * std::max(0.0, -swing_arm);
  }
  return figure;
}

Eigen::Isometry3d at(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// A limb that hangs down, swung forward.
Eigen::Isometry3d forward(double angle_rad) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(-angle_rad, Eigen::Vector3d::UnitY()));
}

void applyFigure(const PersonBody& body, const Figure& figure, Model& model) {
  const auto place = [&model](int part, const Eigen::Isometry3d& pose) {
    model.visuals[static_cast<std::size_t>(part)].model_from_visual = pose;
  };
  const Eigen::Isometry3d torso = at(figure.hip_x_m, 0.0, figure.hip_z_m) * forward(-figure.lean);
  place(body.torso, torso);
  place(body.head, torso * at(0.0, 0.0, body.neck_height_m - body.hip_height_m) * forward(figure.lean));
  for (std::size_t side = 0; side < 2; ++side) {
    const double left = side == 0 ? 1.0 : -1.0;
    const Eigen::Isometry3d out(Eigen::AngleAxisd(left * figure.arms_out, Eigen::Vector3d::UnitX()));
    const Eigen::Isometry3d upper_arm =
        torso * at(0.0, left * body.shoulder_offset_m, body.shoulder_height_m - body.hip_height_m) * out *
        forward(figure.upper_arm[side]);
    place(body.upper_arm[side], upper_arm);
    place(body.forearm[side], upper_arm * at(0.0, 0.0, -body.upper_arm_m) * forward(figure.elbow[side]));

    const LegAngles& leg = figure.legs[side];
    const Eigen::Isometry3d thigh =
        at(figure.hip_x_m, left * body.hip_offset_m, figure.hip_z_m) * forward(leg.thigh);
    const Eigen::Isometry3d shin = thigh * at(0.0, 0.0, -body.thigh_m) * forward(leg.shin - leg.thigh);
    const Eigen::Vector3d ankle = shin * Eigen::Vector3d(0.0, 0.0, -body.shin_m);
    place(body.thigh[side], thigh);
    place(body.shin[side], shin);
    place(body.foot[side], Eigen::Translation3d(ankle) * forward(figure.foot_pitch[side]));
  }
}

void addCylinder(double x, double y, double low_m, double high_m, double radius_m, Model& model) {
  Collision collision;
  collision.kind = Collision::Kind::kCylinder;
  collision.size_m = Eigen::Vector3d(radius_m, radius_m, high_m - low_m);
  collision.model_from_collision = at(x, y, 0.5 * (low_m + high_m));
  model.collisions.push_back(collision);
}

/// Upright cylinders from the floor: legs and trunk; a walker's legs sweep one.
void addCollisions(const PersonBody& body, Posture posture, Model& model) {
  const double scale = body.height_m / 1.75;
  const double shin_radius = 0.075 * scale;
  const double trunk_radius = 0.16 * scale;
  if (posture == Posture::kSitting) {
    const Figure figure = sitting(body);
    const double shin_x = figure.hip_x_m + body.thigh_m * std::sin(figure.legs[0].thigh);
    for (const double left : {1.0, -1.0})
      addCylinder(shin_x, left * body.hip_offset_m, 0.0, figure.hip_z_m, shin_radius, model);
    const double above_hip = body.height_m - body.hip_height_m;
    addCylinder(figure.hip_x_m, 0.0, kSeatHeight_m, figure.hip_z_m + above_hip, trunk_radius, model);
    return;
  }
  if (posture == Posture::kWalking) {
    addCylinder(0.0, 0.0, 0.0, body.hip_height_m, 0.22 * scale, model);
  } else {
    for (const double left : {1.0, -1.0})
      addCylinder(0.0, left * body.hip_offset_m, 0.0, body.hip_height_m, shin_radius, model);
  }
  addCylinder(0.0, 0.0, body.hip_height_m, body.height_m, trunk_radius, model);
}

void checkWaypoints(const Person& person) {
  if (person.waypoints.empty()) throw ConfigError("person \"" + person.name + "\" has no waypoint");
  for (std::size_t i = 0; i < person.waypoints.size(); ++i) {
    const Waypoint& waypoint = person.waypoints[i];
    const bool ascends = i == 0 || waypoint.time_s >= person.waypoints[i - 1].time_s;
    if (!ascends || !std::isfinite(waypoint.time_s) || !waypoint.world_from_person.isFinite()) {
      throw ConfigError("person \"" + person.name +
                        "\": the times of its waypoints must ascend, and all be finite");
    }
  }
}

Eigen::Isometry3d onFloor(const Pose2& pose) {
  return at(pose.x_m, pose.y_m, 0.0) * Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ());
}

}  // namespace

PersonMotion personMotion(const Person& person, double time_s) {
  checkWaypoints(person);
  const std::vector<Waypoint>& way = person.waypoints;
  PersonMotion motion;
  double time = time_s - person.start_delay_s;
  const double duration = way.back().time_s;
  double round_m = 0.0;
  for (std::size_t i = 1; i < way.size(); ++i)
    round_m += distance(way[i - 1].world_from_person, way[i].world_from_person);
  if (person.loop && way.size() > 1 && duration > 0.0 && time > duration) {
    const double rounds = std::floor(time / duration);
    time -= rounds * duration;
    motion.walked_m = rounds * round_m;
  }
  if (time <= way.front().time_s) {
    motion.world_from_person = way.front().world_from_person;
    return motion;
  }
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Waypoint& from = way[i - 1];
    const Waypoint& to = way[i];
    const double length = distance(from.world_from_person, to.world_from_person);
    if (time >= to.time_s) {
      motion.walked_m += length;
      continue;
    }
    const double span = to.time_s - from.time_s;
    const double share = (time - from.time_s) / span;
    motion.world_from_person = interpolate(from.world_from_person, to.world_from_person, share);
    motion.velocity_mps = (to.world_from_person.position() - from.world_from_person.position()) / span;
    motion.walked_m += share * length;
    return motion;
  }
  motion.world_from_person = way.back().world_from_person;
  return motion;
}

std::vector<PersonBody> addPeople(Scene& scene) {
  std::vector<PersonBody> bodies;
  for (std::size_t i = 0; i < scene.people.size(); ++i) {
    checkWaypoints(scene.people[i]);
    const std::string name =
        scene.people[i].name.empty() ? "person_" + std::to_string(i) : scene.people[i].name;
    PersonBody body = addBody(drawLook(scene.people[i].appearance), name, scene);
    body.person = static_cast<int>(i);
    addCollisions(body, scene.people[i].posture, scene.models.back());
    posePerson(body, 0.0, scene);
    bodies.push_back(body);
  }
  return bodies;
}

void posePerson(const PersonBody& body, double time_s, Scene& scene) {
  const Person& person = scene.people[static_cast<std::size_t>(body.person)];
  Model& model = scene.models[static_cast<std::size_t>(body.model)];
  const PersonMotion motion = personMotion(person, time_s);
  model.world_from_model = onFloor(motion.world_from_person);
  switch (person.posture) {
    case Posture::kStanding:
      applyFigure(body, standing(body, person.appearance), model);
      break;
    case Posture::kSitting:
      applyFigure(body, sitting(body), model);
      break;
    case Posture::kWalking:
      applyFigure(body, walking(body, motion.walked_m), model);
      break;
  }
}

}  // namespace frugal_nav::sim
