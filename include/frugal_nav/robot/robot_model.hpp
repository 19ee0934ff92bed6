#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Geometry of the URDF. A box has its full side lengths, a cylinder stands along its z axis.
struct BoxShape {
  Eigen::Vector3d size_m;
};
struct CylinderShape {
  double radius_m;
  double length_m;
};
struct SphereShape {
  double radius_m;
};

/// One shape of the robot, posed in its base frame.
struct RobotShape {
  std::string link;
  std::variant<BoxShape, CylinderShape, SphereShape> geometry;
  Eigen::Isometry3d base_from_shape = Eigen::Isometry3d::Identity();
  Eigen::Vector3f rgb{0.5F, 0.5F, 0.5F};  ///< the visual's colour, sRGB in [0, 1]
};

/// The differential drive.
struct DriveGeometry {
  std::string left_joint;
  std::string right_joint;
  double separation_m = 0.0;  ///< between the wheels' centres
  double radius_m = 0.0;
};

/// A robot as its URDF describes it: the only source of its geometry.
struct RobotModel {
  std::string name;
  DriveGeometry drive;
  std::map<std::string, Eigen::Isometry3d> base_from_link;  ///< every link at joint position zero
  std::vector<RobotShape> visuals;
  std::vector<RobotShape> collisions;
  Polygon2 footprint;  ///< convex hull of the collision shapes on the floor, in base_link
  double mass_kg = 0.0;
  double yaw_inertia_kgm2 = 0.0;  ///< about the vertical axis through base_link

  double circumradius_m() const;  ///< of the footprint about base_link
  double inradius_m() const;      ///< largest circle about base_link inside the footprint
  /// Half of the footprint's extent across the driving direction: the narrowest half passage it fits.
  double halfWidth_m() const;

  /// Pose of a link in base_link; throws ConfigError naming the link when the URDF lacks it.
  const Eigen::Isometry3d& baseFrom(const std::string& link) const;
  /// The same on the floor plane; for a laser that is mounted level.
  Pose2 planarBaseFrom(const std::string& link) const;
};

/// Reads a robot from URDF text, posed in the link `base_frame`: the root, or a link below a fixed
/// base_footprint. The wheels are the two continuous joints whose names hold "left" and "right". Throws
/// ConfigError that names what is missing.
RobotModel parseRobot(const std::string& urdf_xml, const std::string& where,
                      const std::string& base_frame = "base_link");

/// Reads a robot from a URDF file, posed in its base_link.
RobotModel loadRobot(const std::string& path);

}  // namespace frugal_nav
