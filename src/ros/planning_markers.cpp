#include <cmath>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/planning_markers.hpp>

namespace frugal_nav {
namespace {

using visualization_msgs::Marker;

constexpr double kRingInner_m = 0.28;
constexpr double kRingOuter_m = 0.36;
constexpr double kHeight_m = 0.02;  // above the floor, so that the floor does not swallow it

std_msgs::ColorRGBA color(float r, float g, float b, float a) {
  std_msgs::ColorRGBA c;
  c.r = r;
  c.g = g;
  c.b = b;
  c.a = a;
  return c;
}

Marker marker(const std::string& name, int type, const std::string& frame, Stamp stamp) {
  Marker m;
  m.header.frame_id = frame;
  m.header.stamp = toRos(stamp);
  m.ns = name;
  m.type = type;
  m.pose.orientation.w = 1.0;
  return m;
}

geometry_msgs::Point point(double x, double y) {
  geometry_msgs::Point p;
  p.x = x;
  p.y = y;
  p.z = kHeight_m;
  return p;
}

geometry_msgs::Point polar(double bearing_rad, double range_m) {
  return point(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad));
}

std_msgs::ColorRGBA barrierColor(const BaseCommand& command) {
  if (command.reason == BaseCommand::Reason::kIdle) return color(0.4F, 0.4F, 0.4F, 0.9F);
  if (command.reason != BaseCommand::Reason::kNone) return color(0.9F, 0.2F, 0.15F, 0.9F);
  return command.guard_share < 1.0 ? color(0.9F, 0.6F, 0.1F, 0.9F) : color(0.1F, 0.7F, 0.3F, 0.9F);
}

/// A marker that has nothing to show takes its predecessor away.
void removeWhenEmpty(Marker& m) {
  if (m.points.empty()) m.action = Marker::DELETE;
}

}  // namespace

BodyExtent extentOf(const RobotModel& robot) { return {robot.halfWidth_m(), robot.circumradius_m()}; }

nav_msgs::OccupancyGrid gridMessage(const RollingGrid& grid, ros::Time stamp, const std::string& odom_frame) {
  nav_msgs::OccupancyGrid msg;
  msg.header.stamp = msg.info.map_load_time = stamp;
  msg.header.frame_id = odom_frame;
  msg.info.resolution = static_cast<float>(grid.cell_m());
  msg.info.width = msg.info.height = static_cast<std::uint32_t>(grid.size());
  msg.info.origin.position.x = grid.origin().x * grid.cell_m();
  msg.info.origin.position.y = grid.origin().y * grid.cell_m();
  msg.info.origin.orientation.w = 1.0;
  std::vector<RollingGrid::State> row(static_cast<std::size_t>(grid.size()));
  msg.data.reserve(row.size() * row.size());
  for (int y = 0; y < grid.size(); ++y) {
    grid.copyRow(grid.origin().y + y, row.data());
    for (const RollingGrid::State state : row) {
      const int value = state == RollingGrid::State::kOccupied ? 100
                        : state == RollingGrid::State::kFree   ? 0
                                                               : -1;
      msg.data.push_back(static_cast<std::int8_t>(value));
    }
  }
  return msg;
}

visualization_msgs::MarkerArray planMarkers(const LidarPlan& plan, const std::optional<Pose2>& odom_from_goal,
                                            double goal_tolerance_m, const std::string& odom_frame) {
  Marker ribbon = marker("path", Marker::LINE_STRIP, odom_frame, plan.stamp);
  ribbon.scale.x = 0.03;
  ribbon.color = plan.reaches_goal ? color(0.1F, 0.7F, 0.3F, 0.9F) : color(0.9F, 0.6F, 0.1F, 0.9F);
  for (const Pose2& pose : plan.path) ribbon.points.push_back(point(pose.x_m, pose.y_m));

  Marker ring = marker("goal", Marker::LINE_STRIP, odom_frame, plan.stamp);
  ring.scale.x = 0.02;
  ring.color = color(0.1F, 0.4F, 0.9F, 0.9F);
  constexpr int kPieces = 36;
  for (int i = 0; odom_from_goal && i <= kPieces; ++i) {
    const geometry_msgs::Point p = polar(2.0 * M_PI * i / kPieces, goal_tolerance_m);
    ring.points.push_back(point(odom_from_goal->x_m + p.x, odom_from_goal->y_m + p.y));
  }
  // Where what moves will be within two seconds.
  constexpr double kPredicted_s = 2.0;
  Marker moving = marker("moving", Marker::LINE_LIST, odom_frame, plan.stamp);
  moving.scale.x = 0.06;
  moving.color = color(0.9F, 0.2F, 0.15F, 0.9F);
  for (const TrackedObstacle& obstacle : plan.moving) {
    for (const Eigen::Vector2d& p : {obstacle.p_odom, obstacle.at(kPredicted_s)})
      moving.points.push_back(point(p.x(), p.y()));
  }
  visualization_msgs::MarkerArray array;
  for (Marker* m : {&ribbon, &ring, &moving}) {
    removeWhenEmpty(*m);
    array.markers.push_back(*m);
  }
  return array;
}

visualization_msgs::MarkerArray sectorMarkers(const SectorAvoidance::Decision& decision,
                                              const MotionCommand& command, const std::string& base_frame,
                                              const std::string& odom_frame) {
  Marker ring = marker("sectors", Marker::TRIANGLE_LIST, base_frame, command.stamp);
  ring.scale.x = ring.scale.y = ring.scale.z = 1.0;
  ring.color = color(1.0F, 1.0F, 1.0F, 1.0F);
  const double half = 0.45 * decision.ring.width_rad();  // a gap between neighbours
  const int chosen = decision.found ? decision.ring.sectorOf(decision.bearing_rad) : -1;
  for (int i = 0; i < decision.ring.size(); ++i) {
    const double bearing = decision.ring.bearingOf(i);
    const auto c = i == chosen               ? color(0.1F, 0.4F, 0.95F, 0.95F)
                   : decision.ring.isFree(i) ? color(0.2F, 0.75F, 0.3F, 0.6F)
                                             : color(0.9F, 0.2F, 0.15F, 0.6F);
    const auto a = polar(bearing - half, kRingInner_m);
    const auto b = polar(bearing - half, kRingOuter_m);
    const auto d = polar(bearing + half, kRingOuter_m);
    const auto e = polar(bearing + half, kRingInner_m);
    for (const auto& corner : {a, b, d, a, d, e}) {
      ring.points.push_back(corner);
      ring.colors.push_back(c);
    }
  }
  Marker target = marker("target", Marker::SPHERE, odom_frame, command.stamp);
  target.pose = toRos(command.odom_from_target);
  target.scale.x = target.scale.y = target.scale.z = 0.08;
  target.color = color(0.1F, 0.4F, 0.95F, 0.95F);
  if (command.holds != MotionCommand::Holds::kTarget) target.action = Marker::DELETE;
  Marker candidates = marker("candidates", Marker::LINE_LIST, base_frame, command.stamp);
  candidates.scale.x = 0.015;
  candidates.color = color(0.1F, 0.4F, 0.95F, 0.6F);
  for (const double bearing : decision.candidates_rad) {
    candidates.points.push_back(polar(bearing, kRingOuter_m));
    candidates.points.push_back(polar(bearing, 1.5 * kRingOuter_m));
  }
  removeWhenEmpty(candidates);
  visualization_msgs::MarkerArray array;
  array.markers = {ring, candidates, target};
  return array;
}

visualization_msgs::MarkerArray barrierMarkers(const BaseCommand& command, Stamp stamp,
                                               const Polygon2& footprint, const std::string& base_frame) {
  Marker outline = marker("barrier", Marker::LINE_STRIP, base_frame, stamp);
  outline.scale.x = 0.02;
  outline.color = barrierColor(command);
  for (std::size_t i = 0; i <= footprint.size(); ++i) {
    const Eigen::Vector2d& corner = footprint[i % footprint.size()];
    outline.points.push_back(point(corner.x(), corner.y()));
  }
  Marker reason = marker("barrier_reason", Marker::TEXT_VIEW_FACING, base_frame, stamp);
  reason.scale.z = 0.12;
  reason.pose.position.z = 0.5;
  reason.color = outline.color;
  reason.text = command.text;
  if (command.text.empty() && command.guard_share < 1.0) reason.text = "slowed for an obstacle";
  if (reason.text.empty()) reason.action = Marker::DELETE;
  visualization_msgs::MarkerArray array;
  array.markers = {outline, reason};
  return array;
}

}  // namespace frugal_nav
