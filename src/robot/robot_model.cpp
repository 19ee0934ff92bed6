#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <urdf_parser/urdf_parser.h>

#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav {
namespace {

Eigen::Isometry3d toIsometry(const urdf::Pose& pose) {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
  pose.rotation.getQuaternion(x, y, z, w);
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  result.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return result;
}

void collectLinks(const urdf::LinkConstSharedPtr& link, const Eigen::Isometry3d& root_from_link,
                  std::map<std::string, Eigen::Isometry3d>& poses) {
  poses[link->name] = root_from_link;
  for (const auto& joint : link->child_joints) {
    const auto child =
        std::find_if(link->child_links.begin(), link->child_links.end(),
                     [&joint](const auto& candidate) { return candidate->name == joint->child_link_name; });
    if (child == link->child_links.end()) continue;
    collectLinks(*child, root_from_link * toIsometry(joint->parent_to_joint_origin_transform), poses);
  }
}

template <class Element>
bool readShape(const Element& element, const Eigen::Isometry3d& base_from_link, RobotShape& shape) {
  shape.base_from_shape = base_from_link * toIsometry(element.origin);
  if (!element.geometry) return false;
  switch (element.geometry->type) {
    case urdf::Geometry::BOX: {
      const auto& dim = static_cast<const urdf::Box&>(*element.geometry).dim;
      shape.geometry = BoxShape{{dim.x, dim.y, dim.z}};
      return true;
    }
    case urdf::Geometry::CYLINDER: {
      const auto& cylinder = static_cast<const urdf::Cylinder&>(*element.geometry);
      shape.geometry = CylinderShape{cylinder.radius, cylinder.length};
      return true;
    }
    case urdf::Geometry::SPHERE:
      shape.geometry = SphereShape{static_cast<const urdf::Sphere&>(*element.geometry).radius};
      return true;
    default:
      return false;  // meshes are not drawn
  }
}

void collectShapes(const urdf::Link& link, const Eigen::Isometry3d& base_from_link, RobotModel& robot) {
  for (const auto& visual : link.visual_array) {
    RobotShape shape;
    shape.link = link.name;
    if (!readShape(*visual, base_from_link, shape)) continue;
    if (visual->material) {
      const auto& color = visual->material->color;
      shape.rgb = Eigen::Vector3f(color.r, color.g, color.b);
    }
    robot.visuals.push_back(shape);
  }
  for (const auto& collision : link.collision_array) {
    RobotShape shape;
    shape.link = link.name;
    if (!readShape(*collision, base_from_link, shape)) {
      throw ConfigError(
          "link \"" + link.name +
          "\": its collision is a mesh, which tells no footprint; give it boxes, cylinders or spheres");
    }
    robot.collisions.push_back(shape);
  }
}

std::vector<Eigen::Vector3d> outline(const RobotShape& shape) {
  constexpr int kRoundCorners = 32;
  std::vector<Eigen::Vector3d> points;
  if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                                 (corner & 4) != 0 ? 0.5 : -0.5);
      points.emplace_back(sign.cwiseProduct(box->size_m));
    }
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
    for (int i = 0; i < kRoundCorners; ++i) {
      const double angle = 2.0 * M_PI * i / kRoundCorners;
      for (const double end : {-0.5, 0.5}) {
        points.emplace_back(cylinder->radius_m * std::cos(angle), cylinder->radius_m * std::sin(angle),
                            end * cylinder->length_m);
      }
    }
  } else {
    const double radius = std::get<SphereShape>(shape.geometry).radius_m;
    const Eigen::Matrix3d shape_from_base = shape.base_from_shape.linear().transpose();
    for (int i = 0; i < kRoundCorners; ++i) {  // the equator as seen from above
      const double angle = 2.0 * M_PI * i / kRoundCorners;
      points.emplace_back(shape_from_base *
                          Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0));
    }
  }
  for (Eigen::Vector3d& point : points) point = shape.base_from_shape * point;
  return points;
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
Polygon2 convexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  const auto leftTurn = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 1e-12;
  };
  Polygon2 hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= start + 2 && !leftTurn(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();  // the first of the next pass
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

DriveGeometry readDrive(const urdf::ModelInterface& model, const RobotModel& robot,
                        const std::string& where) {
  DriveGeometry drive;
  std::string left_link, right_link;
  const auto take = [&where](const urdf::Joint& joint, std::string& known, std::string& link) {
    if (!known.empty()) {
      throw ConfigError(where + ": both \"" + known + "\" and \"" + joint.name +
                        "\" are continuous joints of one side; a differential drive has one");
    }
    known = joint.name;
    link = joint.child_link_name;
  };
  for (const auto& [name, joint] : model.joints_) {
    if (joint->type != urdf::Joint::CONTINUOUS) continue;
    if (name.find("left") != std::string::npos) {
      take(*joint, drive.left_joint, left_link);
    } else if (name.find("right") != std::string::npos) {
      take(*joint, drive.right_joint, right_link);
    }
  }
  if (left_link.empty() || right_link.empty()) {
    throw ConfigError(where +
                      ": no wheels: expected two continuous joints whose names hold \"left\" and \"right\"");
  }
  drive.separation_m =
      (robot.baseFrom(left_link).translation() - robot.baseFrom(right_link).translation()).norm();
  for (const RobotShape& shape : robot.collisions) {
    if (shape.link != left_link) continue;
    if (const auto* wheel = std::get_if<CylinderShape>(&shape.geometry)) drive.radius_m = wheel->radius_m;
    if (const auto* wheel = std::get_if<SphereShape>(&shape.geometry)) drive.radius_m = wheel->radius_m;
  }
  if (!(drive.radius_m > 0.0)) {
    throw ConfigError(where + ": link \"" + left_link +
                      "\" has no cylinder or sphere collision to read the wheel radius from");
  }
  if (!(drive.separation_m > 0.0)) throw ConfigError(where + ": both wheels are at the same place");
  return drive;
}

void addInertia(const urdf::Link& link, const Eigen::Isometry3d& base_from_link, RobotModel& robot) {
  if (!link.inertial) return;
  const Eigen::Vector3d centre = (base_from_link * toIsometry(link.inertial->origin)).translation();
  robot.mass_kg += link.inertial->mass;
  robot.yaw_inertia_kgm2 += link.inertial->izz + link.inertial->mass * centre.head<2>().squaredNorm();
}

}  // namespace

double RobotModel::circumradius_m() const {
  double radius = 0.0;
  for (const Eigen::Vector2d& corner : footprint) radius = std::max(radius, corner.norm());
  return radius;
}

double RobotModel::inradius_m() const {
  double radius = circumradius_m();
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    const Eigen::Vector2d& a = footprint[i];
    const Eigen::Vector2d edge = footprint[(i + 1) % footprint.size()] - a;
    radius = std::min(radius, (edge.x() * -a.y() + edge.y() * a.x()) / edge.norm());
  }
  return radius;
}

double RobotModel::halfWidth_m() const {
  double half = 0.0;
  for (const Eigen::Vector2d& corner : footprint) half = std::max(half, std::abs(corner.y()));
  return half;
}

const Eigen::Isometry3d& RobotModel::baseFrom(const std::string& link) const {
  const auto found = base_from_link.find(link);
  if (found == base_from_link.end())
    throw ConfigError("robot \"" + name + "\": the URDF has no link \"" + link + "\"");
  return found->second;
}

Pose2 RobotModel::planarBaseFrom(const std::string& link) const { return toPose2(baseFrom(link)); }

RobotModel parseRobot(const std::string& urdf_xml, const std::string& where, const std::string& base_frame) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf_xml);
  if (!model || !model->getRoot())
    throw ConfigError(where + ": is not a valid URDF (see the messages above)");
  RobotModel robot;
  robot.name = model->getName();
  collectLinks(model->getRoot(), Eigen::Isometry3d::Identity(), robot.base_from_link);
  const Eigen::Isometry3d base_from_root = robot.baseFrom(base_frame).inverse();
  for (auto& [name, pose] : robot.base_from_link) pose = base_from_root * pose;
  for (const auto& [name, link] : model->links_) {
    collectShapes(*link, robot.baseFrom(name), robot);
    addInertia(*link, robot.baseFrom(name), robot);
  }
  if (robot.collisions.empty()) throw ConfigError(where + ": no collision shape to read the footprint from");
  std::vector<Eigen::Vector2d> floor_points;
  for (const RobotShape& shape : robot.collisions) {
    for (const Eigen::Vector3d& point : outline(shape)) floor_points.push_back(point.head<2>());
  }
  robot.footprint = convexHull(floor_points);
  robot.drive = readDrive(*model, robot, where);
  if (!(robot.inradius_m() > 0.0))
    throw ConfigError(where + ": " + base_frame + " lies outside the footprint");
  return robot;
}

RobotModel loadRobot(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError(path + ": cannot be read; is the path right?");
  std::stringstream text;
  text << file.rdbuf();
  return parseRobot(text.str(), path);
}

}  // namespace frugal_nav
