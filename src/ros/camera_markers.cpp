#include <algorithm>
#include <cmath>

#include <frugal_nav/ros/camera_markers.hpp>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {
namespace {

using visualization_msgs::Marker;

constexpr double kHeight_m = 0.03;  // above the floor, so that the floor does not swallow it
constexpr double kNameHeight_m = 0.3;
constexpr double kPredicted_s = 2.0;

struct Color {
  float r, g, b, a;
};
constexpr Color kGreen{0.1F, 0.7F, 0.3F, 0.9F};
constexpr Color kOrange{0.9F, 0.6F, 0.1F, 0.9F};
constexpr Color kBlue{0.1F, 0.4F, 0.95F, 0.9F};
constexpr Color kRed{0.9F, 0.2F, 0.15F, 0.9F};
constexpr Color kGrey{0.4F, 0.4F, 0.4F, 0.9F};
constexpr Color kViolet{0.6F, 0.2F, 0.8F, 0.7F};
constexpr Color kBlack{0.05F, 0.05F, 0.05F, 1.0F};

Marker marker(const std::string& name, int type, const CameraPlan& plan, const std::string& frame,
              const Color& color) {
  Marker m;
  m.header.frame_id = frame;
  m.header.stamp = toRos(plan.stamp);
  m.ns = name;
  m.type = type;
  m.pose.orientation.w = 1.0;
  m.color.r = color.r;
  m.color.g = color.g;
  m.color.b = color.b;
  m.color.a = color.a;
  return m;
}

geometry_msgs::Point point(const Eigen::Vector2d& p) {
  geometry_msgs::Point msg;
  msg.x = p.x();
  msg.y = p.y();
  msg.z = kHeight_m;
  return msg;
}

/// One node of the grid: a flat disc, taken away when it is not there.
Marker node(const std::string& name, const std::optional<Eigen::Vector2d>& p, double diameter_m,
            const CameraPlan& plan, const std::string& frame, const Color& color) {
  Marker m = marker(name, Marker::CYLINDER, plan, frame, color);
  if (!p) {
    m.action = Marker::DELETE;
    return m;
  }
  m.pose.position = point(*p);
  m.scale.x = m.scale.y = diameter_m;
  m.scale.z = 0.02;
  return m;
}

/// What a node is, in words beside it.
Marker name(int id, const std::string& text, const std::optional<Eigen::Vector2d>& p, const CameraPlan& plan,
            const std::string& frame) {
  Marker m = marker("names", Marker::TEXT_VIEW_FACING, plan, frame, kBlack);
  m.id = id;
  if (!p) {
    m.action = Marker::DELETE;
    return m;
  }
  m.text = text;
  m.pose.position = point(*p);
  m.pose.position.z = kNameHeight_m;
  m.scale.z = 0.14;
  return m;
}

/// Where each moving obstacle will be, as a line from where it is.
Marker predictions(const CameraPlan& plan, const std::string& frame) {
  Marker m = marker("moving", Marker::LINE_LIST, plan, frame, kViolet);
  m.scale.x = 0.04;
  for (const TrackedObstacle& obstacle : plan.moving) {
    m.points.push_back(point(obstacle.p_odom));
    m.points.push_back(point(obstacle.at(kPredicted_s)));
  }
  if (m.points.empty()) m.action = Marker::DELETE;
  return m;
}

}  // namespace

visualization_msgs::MarkerArray cameraPlanMarkers(const CameraPlan& plan,
                                                  const std::optional<Pose2>& odom_from_goal,
                                                  const std::string& odom_frame) {
  Marker ribbon = marker("path", Marker::LINE_STRIP, plan, odom_frame, plan.reaches_goal ? kGreen : kOrange);
  ribbon.scale.x = 0.03;
  for (const Pose2& pose : plan.path) ribbon.points.push_back(point(pose.position()));
  if (ribbon.points.size() < 2) ribbon.action = Marker::DELETE;

  std::optional<Eigen::Vector2d> goal, obstacle;
  if (odom_from_goal) goal = odom_from_goal->position();
  double obstacle_m = 0.12;
  if (plan.obstacle) {
    obstacle = plan.obstacle->p_odom;
    if (std::isfinite(plan.obstacle->sigma_m)) obstacle_m += 2.0 * plan.obstacle->sigma_m;
  }
  visualization_msgs::MarkerArray array;
  array.markers = {ribbon,
                   node("robot", plan.robot.position(), 0.12, plan, odom_frame, kGrey),
                   node("goal", goal, 0.30, plan, odom_frame, kBlue),
                   node("gap", plan.gap, 0.15, plan, odom_frame, kGreen),
                   node("obstacle", obstacle, obstacle_m, plan, odom_frame, kRed),
                   name(0, "goal", goal, plan, odom_frame),
                   name(1, "gap", plan.gap, plan, odom_frame),
                   name(2, "nearest obstacle", obstacle, plan, odom_frame),
                   predictions(plan, odom_frame)};
  return array;
}

}  // namespace frugal_nav
