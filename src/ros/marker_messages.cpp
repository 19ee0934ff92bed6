#include <limits>
#include <map>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/marker_messages.hpp>
#include <frugal_nav/ros/visual_messages.hpp>

namespace frugal_nav {
namespace {

using visualization_msgs::Marker;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MarkerObservation observation(const MarkerImageResult& result, const MarkerSighting& sighting,
                              const MarkerMap& map) {
  MarkerObservation msg;
  msg.id = sighting.corners.id;
  const auto mapped = map.markers.find(msg.id);
  msg.size_m = mapped == map.markers.end() ? kNan : mapped->second.size_m;
  for (std::size_t i = 0; i < 4; ++i) {
    msg.corners_px[2 * i] = sighting.corners.pixels[i].x();
    msg.corners_px[2 * i + 1] = sighting.corners.pixels[i].y();
  }
  msg.image_error_px = msg.other_image_error_px = msg.object_error_m = kNan;
  msg.pose.pose.orientation.w = msg.other_pose.orientation.w = 1.0;
  const MarkerPose& pose = sighting.pose;
  msg.has_pose = !pose.solutions.empty();
  if (msg.has_pose) {
    msg.pose.pose = toRos(pose.solutions[0].camera_from_marker);
    Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(msg.pose.covariance.data()) = pose.covariance;
    msg.image_error_px = pose.solutions[0].image_error_px;
    msg.object_error_m = pose.object_error_m;
  }
  msg.has_other_pose = pose.solutions.size() > 1;
  if (msg.has_other_pose) {
    msg.other_pose = toRos(pose.solutions[1].camera_from_marker);
    msg.other_image_error_px = pose.solutions[1].image_error_px;
  }
  msg.error_ratio = pose.error_ratio;
  msg.accepted = result.isAccepted(sighting);
  msg.reason = result.reason(sighting);
  return msg;
}

std_msgs::ColorRGBA colorOf(float r, float g, float b, float a) {
  std_msgs::ColorRGBA color;
  color.r = r;
  color.g = g;
  color.b = b;
  color.a = a;
  return color;
}

Marker shape(const std::string& name, int id, int type, const std_msgs::Header& header,
             const std_msgs::ColorRGBA& color) {
  Marker marker;
  marker.header = header;
  marker.ns = name;
  marker.id = id;
  marker.type = type;
  marker.color = color;
  marker.pose.orientation.w = 1.0;
  return marker;
}

geometry_msgs::Point point(const Eigen::Vector3d& p) {
  geometry_msgs::Point msg;
  msg.x = p.x();
  msg.y = p.y();
  msg.z = p.z();
  return msg;
}

/// The marker's face as a thin board, and its id above it.
void addBoard(const MappedMarker& mapped, const std_msgs::Header& header, const std_msgs::ColorRGBA& color,
              visualization_msgs::MarkerArray& array) {
  constexpr double kThickness_m = 0.01;
  Marker board = shape("map", mapped.id, Marker::CUBE, header, color);
  board.pose = toRos(mapped.map_from_marker);
  board.scale.x = board.scale.y = mapped.size_m;
  board.scale.z = kThickness_m;
  Marker name = shape("ids", mapped.id, Marker::TEXT_VIEW_FACING, header, colorOf(0.1F, 0.1F, 0.1F, 1.0F));
  name.pose.position = board.pose.position;
  name.pose.position.z += 1.2 * mapped.size_m;
  name.scale.z = mapped.size_m;
  name.text = std::to_string(mapped.id);
  array.markers.push_back(board);
  array.markers.push_back(name);
}

}  // namespace

MarkerObservationArray observationsMessage(const CameraFrame& frame, const MarkerImageResult& result,
                                           const MarkerMap& map) {
  MarkerObservationArray msg;
  msg.header = headerOf(frame);
  msg.image_width = static_cast<std::uint32_t>(frame.width_px);
  msg.image_height = static_cast<std::uint32_t>(frame.height_px);
  for (const MarkerSighting& sighting : result.fix.sightings)
    msg.markers.push_back(observation(result, sighting, map));
  msg.unlisted_ids.assign(result.unlisted_ids.begin(), result.unlisted_ids.end());
  msg.accepted = result.isUsed();
  msg.reason = result.reason();
  msg.image_error_px = result.fix.isGood() ? result.fix.image_error_px : kNan;
  return msg;
}

geometry_msgs::PoseWithCovarianceStamped poseMessage(Stamp stamp, const std::string& frame, const Pose2& pose,
                                                     const Eigen::Matrix3d& covariance) {
  geometry_msgs::PoseWithCovarianceStamped msg;
  msg.header.stamp = toRos(stamp);
  msg.header.frame_id = frame;
  msg.pose = toRos(pose, covariance);
  return msg;
}

GivenPose givenPose(const geometry_msgs::PoseWithCovarianceStamped& msg, const std::string& map_frame,
                    double sigma_m, double sigma_rad) {
  GivenPose given;
  const std::optional<Pose2> pose = planar(msg.pose.pose);
  if (!pose) {
    given.fault = "not finite, or no sound quaternion";
  } else if (msg.header.frame_id != map_frame) {
    given.fault = "frame \"" + msg.header.frame_id + "\" instead of \"" + map_frame + "\"";
  } else {
    given.fix.map_from_base = *pose;
  }
  given.fix.covariance = planarCovariance(msg.pose);
  if (given.fix.covariance.isZero(0.0)) {
    given.fix.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  }
  return given;
}

visualization_msgs::MarkerArray mapMarkers(const MarkerMap& map, const MarkerImageResult& result,
                                           const Eigen::Isometry3d& map_from_optical) {
  const std_msgs::ColorRGBA grey = colorOf(0.35F, 0.35F, 0.4F, 1.0F);
  const std_msgs::ColorRGBA green = colorOf(0.17F, 0.63F, 0.17F, 1.0F);
  const std_msgs::ColorRGBA red = colorOf(0.84F, 0.15F, 0.16F, 1.0F);
  std_msgs::Header header;
  header.frame_id = map.frame;
  header.stamp = toRos(result.stamp);
  visualization_msgs::MarkerArray array;
  Marker rays = shape("seen", 0, Marker::LINE_LIST, header, green);
  rays.scale.x = 0.01;
  std::map<int, std_msgs::ColorRGBA> seen;
  for (const MarkerSighting& sighting : result.fix.sightings) {
    const std_msgs::ColorRGBA& color = result.isAccepted(sighting) ? green : red;
    seen[sighting.corners.id] = color;
    if (sighting.pose.solutions.empty()) continue;
    const Eigen::Isometry3d& camera_from_marker = sighting.pose.solutions[0].camera_from_marker;
    rays.points.push_back(point(map_from_optical.translation()));
    rays.points.push_back(point(map_from_optical * camera_from_marker.translation()));
    rays.colors.insert(rays.colors.end(), 2, color);
  }
  if (rays.points.empty()) rays.action = Marker::DELETE;
  array.markers.push_back(rays);
  for (const auto& [id, mapped] : map.markers) {
    const auto color = seen.find(id);
    addBoard(mapped, header, color == seen.end() ? grey : color->second, array);
  }
  return array;
}

}  // namespace frugal_nav
