// Bodies from rings: lengths are those of a person 1.75 m tall and scale with the height.
#include "person_body.hpp"

#include "body_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace frugal_nav::sim {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kCommonHeight_m = 1.75;

/// Indices into Scene::materials.
struct BodyMaterials {
  int face, skin, hair, shirt, sleeve, trousers, shoes;
};

int addMaterial(const std::string& name, const Eigen::Vector3f& color, Scene& scene) {
  Material material;
  material.name = name;
  material.albedo = color;
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

int addMaterial(const std::string& name, Texture texture, Scene& scene) {
  texture.name = name;
  scene.textures.push_back(std::move(texture));
  const int index = addMaterial(name, Eigen::Vector3f::Ones(), scene);
  scene.materials.back().texture = static_cast<int>(scene.textures.size()) - 1;
  return index;
}

BodyMaterials addMaterials(const PersonLook& look, const std::string& name, Scene& scene) {
  BodyMaterials materials{};
  materials.face = addMaterial(name + "/face", paintHead(look), scene);
  materials.skin = addMaterial(name + "/skin", look.skin, scene);
  materials.hair = addMaterial(name + "/hair", paintHair(look.hair, look.grain), scene);
  materials.shirt = addMaterial(name + "/shirt", paintShirt(look), scene);
  // What is printed on the breast is not on the sleeves.
  const bool on_breast = look.pattern == ShirtPattern::kPrint || look.pattern == ShirtPattern::kOpenJacket;
  materials.sleeve =
      on_breast ? addMaterial(name + "/sleeve", paintCloth(look.shirt, look.grain), scene) : materials.shirt;
  materials.trousers = addMaterial(name + "/trousers", paintCloth(look.trousers, look.grain), scene);
  materials.shoes = addMaterial(name + "/shoes", look.shoes, scene);
  return materials;
}

double bell(double x, double sigma) { return std::exp(-0.5 * x * x / (sigma * sigma)); }

/// The head's surface about its middle: an ellipsoid with jaw, chin, nose and eye sockets.
Eigen::Vector3d headPoint(double longitude, double latitude) {
  const double height = std::sin(latitude);
  const double girth = std::cos(latitude);
  Eigen::Vector3d p(kHeadRadii_m.x() * girth * std::cos(longitude),
                    kHeadRadii_m.y() * girth * jawWidth(height) * std::sin(longitude),
                    kHeadRadii_m.z() * height);
  const double z_mm = 1000.0 * p.z();
  double nose_mm = 0.0;
  if (z_mm > -36.5 && z_mm < 10.0) nose_mm = 22.0 * (10.0 - z_mm) / 46.5;
  if (z_mm <= -36.5 && z_mm > -43.0) nose_mm = 22.0 * (z_mm + 43.0) / 6.5;
  const double socket_mm = 4.0 * bell(1000.0 * std::abs(p.y()) - 31.0, 11.0) * bell(z_mm - 2.0, 9.0);
  const double chin_mm = 27.0 * bell(longitude, 0.45) * bell(height + 0.86, 0.17) +
                         6.0 * bell(longitude, 0.6) * bell(height + 0.5, 0.12);
  if (std::cos(longitude) > 0.0) {
    p.x() += 0.001 * (nose_mm * bell(longitude, 0.15) - socket_mm + chin_mm);
  } else {
    p.x() -= 0.010 * bell(height - 0.25, 0.4) * -std::cos(longitude) * girth;  // the back of the head
  }
  return p;
}

/// Columns that crowd at the face.
std::vector<double> headLongitudes() {
  constexpr int kHalf = 12;
  std::vector<double> longitudes;
  for (int i = -kHalf; i <= kHalf; ++i) {
    const double share = static_cast<double>(i) / kHalf;
    longitudes.push_back(std::copysign(M_PI * std::pow(std::abs(share), 1.5), share));
  }
  return longitudes;
}

/// A sheet over the sphere of directions; `point` gives its surface.
template <class Point>
Sheet headSheet(const std::vector<double>& latitudes_deg, int material, const Point& point) {
  const std::vector<double> longitudes = headLongitudes();
  Sheet sheet;
  for (const double longitude : longitudes) sheet.column_u.push_back(longitude / (2.0 * M_PI) + 0.5);
  for (const double degrees : latitudes_deg) {
    std::vector<Eigen::Vector3d> row;
    for (std::size_t i = 0; i + 1 < longitudes.size(); ++i)
      row.push_back(point(longitudes[i], degrees * kDegree));
    sheet.rows.push_back(row);
    sheet.row_v.push_back(degrees / 180.0 + 0.5);
    sheet.band_material.push_back(material);
  }
  return sheet;
}

void addFace(const BodyMaterials& materials, Mesh& mesh) {
  const std::vector<double> latitudes_deg = {-90, -72, -60, -50, -42, -35, -29, -23, -18, -12,
                                             -5,  3,   10,  18,  28,  40,  52,  65,  78,  90};
  addSheet(headSheet(latitudes_deg, materials.face, headPoint), mesh);
  for (const double side : {-1.0, 1.0}) {
    addEllipsoid({-0.008, side * (kHeadRadii_m.y() + 0.001), -0.012}, {0.019, 0.010, 0.031}, materials.skin,
                 mesh);
  }
}

double hairThickness(HairStyle style) {
  switch (style) {
    case HairStyle::kFull:
      return 0.021;
    case HairStyle::kCurly:
      return 0.040;
    case HairStyle::kLong:
      return 0.018;
    default:
      return 0.010;
  }
}

void addHair(const PersonLook& look, const BodyMaterials& materials, Mesh& mesh) {
  if (look.hair_style == HairStyle::kBald) return;
  const bool is_long = look.hair_style == HairStyle::kLong;
  const double thickness = hairThickness(look.hair_style);
  constexpr double kHidden = -0.008;  // where no hair grows the cap runs below the skin
  constexpr double kLength = 0.25;    // of long hair below the ears
  const auto surface = [&](double longitude, double latitude) {
    const double line = hairline(look.hair_style, longitude);
    const double share = std::clamp((latitude - line) / 0.20, 0.0, 1.0);
    const double wave = look.hair_style == HairStyle::kCurly
                            ? 0.004 * std::sin(9.0 * longitude) * std::sin(11.0 * latitude)
                            : 0.0;
    const double grown = kHidden + (thickness + wave - kHidden) * share * (2.0 - share);
    if (is_long && latitude < 0.0) {  // falls straight from the widest part
      const double fall = -latitude / (0.5 * M_PI);
      const Eigen::Vector3d at = headPoint(longitude, 0.0);
      const Eigen::Vector3d out(at.x(), at.y(), 0.0);
      constexpr double kBehindFace_m = 0.03;  // where none grows the curtain's ends meet inside the neck
      const double hanging = kBehindFace_m + share * (out.norm() + grown - 0.012 * fall - kBehindFace_m);
      const double width = fall > 0.99 ? 0.0 : hanging;
      return Eigen::Vector3d(out.normalized() * width - Eigen::Vector3d(0.012 * fall, 0, kLength * fall));
    }
    const Eigen::Vector3d at = headPoint(longitude, latitude);
    return Eigen::Vector3d(at + grown * at.normalized());
  };
  const std::vector<double> latitudes_deg =
      is_long ? std::vector<double>{-90, -85, -60, -30, -12, 0, 12, 24, 36, 46, 56, 68, 80, 90}
              : std::vector<double>{-50, -38, -26, -14, -4, 6, 16, 26, 36, 46, 56, 68, 80, 90};
  addSheet(headSheet(latitudes_deg, materials.hair, surface), mesh);
  if (look.hair_style == HairStyle::kBun)
    addEllipsoid({-0.085, 0, 0.085}, {0.045, 0.05, 0.042}, materials.hair, mesh);
}

/// About the neck's base.
Mesh makeHead(const PersonLook& look, const BodyMaterials& materials, double chin_height) {
  Mesh mesh;
  addFace(materials, mesh);
  addHair(look, materials, mesh);
  Eigen::Isometry3d neck_from_head = Eigen::Isometry3d::Identity();
  neck_from_head.translation() = Eigen::Vector3d(0.018, 0.0, chin_height + kHeadRadii_m.z());
  return moved(std::move(mesh), neck_from_head);
}

/// About the middle between the hips; `hip` is their height above the floor.
Mesh makeTorso(const PersonLook& look, const BodyMaterials& m, double hip) {
  const double wide = look.broad_shoulders ? 1.0 : 0.9;
  const double waist = look.broad_shoulders ? 0.140 : 0.122;
  const double hips = look.broad_shoulders ? 0.163 : 0.172;
  const double belly = 0.100 * look.girth + 0.12 * std::max(0.0, look.girth - 1.0);
  const double g = look.girth;
  Mesh mesh;
  addLoft({{0.800 - hip, 0.070 * g, 0.110 * g, 0.0, m.trousers},
           {0.850 - hip, 0.103 * g, hips * g, -0.008, m.trousers},
           {0.930 - hip, 0.106 * g, hips * g, -0.006, m.trousers},
           {0.955 - hip, 0.104 * g, hips * g, 0.0, m.shirt},
           {0.960 - hip, 0.110 * g, (hips + 0.006) * g, 0.0, m.shirt},
           {1.050 - hip, belly, (waist + 0.010) * g, 0.004, m.shirt},
           {1.130 - hip, belly, waist * g, 0.006, m.shirt},
           {1.250 - hip, 0.114 * g, 0.162 * wide * g, 0.008, m.shirt},
           {1.340 - hip, 0.110 * g, 0.174 * wide * g, 0.002, m.shirt},
           {1.390 - hip, 0.092, 0.196 * wide, -0.004, m.shirt},
           {1.418 - hip, 0.075, 0.172 * wide, -0.007, m.shirt},
           {1.446 - hip, 0.064, 0.112 * wide, -0.008, m.shirt},
           {1.470 - hip, 0.059, 0.070, -0.006, m.shirt},
           {1.482 - hip, 0.058, 0.062, -0.004, m.skin},
           {1.484 - hip, 0.053, 0.056, -0.004, m.skin},
           {1.510 - hip, 0.051, 0.053, 0.002, m.skin},
           {1.590 - hip, 0.050, 0.052, 0.008, m.skin}},
          20, 2.3, mesh);
  return mesh;
}

Mesh makeUpperArm(const PersonLook& look, const BodyMaterials& m, double length) {
  const double g = look.girth;
  const int lower = look.long_sleeves ? m.sleeve : m.skin;
  const double sleeve = look.long_sleeves ? 1.0 : 0.88;
  Mesh mesh;
  addLoft({{-length - 0.02, 0.036 * g * sleeve, 0.036 * g * sleeve, 0.0, lower},
           {-length, 0.043 * g * sleeve, 0.042 * g * sleeve, 0.0, lower},
           {-0.170, 0.048 * g * sleeve, 0.046 * g * sleeve, 0.0, lower},
           {-0.165, 0.053 * g, 0.050 * g, 0.0, m.sleeve},
           {-0.060, 0.057 * g, 0.051 * g, 0.0, m.sleeve},
           {-0.015, 0.053, 0.049, 0.0, m.sleeve},
           {0.010, 0.042, 0.039, -0.001, m.sleeve},
           {0.026, 0.022, 0.022, -0.002, m.sleeve}},
          12, 2.0, mesh);
  return mesh;
}

/// Forearm and hand, the thumb ahead.
Mesh makeForearm(const PersonLook& look, const BodyMaterials& m, double length) {
  const double g = look.girth;
  const int sleeve = look.long_sleeves ? m.sleeve : m.skin;
  const double cloth = look.long_sleeves ? 1.0 : 0.86;
  Mesh mesh;
  addLoft({{-length - 0.185, 0.012, 0.007, 0.004, m.skin},
           {-length - 0.165, 0.028, 0.011, 0.004, m.skin},
           {-length - 0.090, 0.040, 0.015, 0.004, m.skin},
           {-length - 0.035, 0.036, 0.017, 0.002, m.skin},
           {-length, 0.026, 0.021, 0.0, m.skin},
           {-length + 0.012, 0.027, 0.023, 0.0, sleeve},
           {-length + 0.014, 0.034 * cloth, 0.031 * cloth, 0.0, sleeve},
           {-0.150, 0.041 * g * cloth, 0.038 * g * cloth, 0.0, sleeve},
           {-0.040, 0.044 * g * cloth, 0.043 * g * cloth, 0.0, sleeve},
           {0.015, 0.038 * g * cloth, 0.038 * g * cloth, 0.0, sleeve}},
          12, 2.0, mesh);
  addEllipsoid({0.038, 0.0, -length - 0.065}, {0.012, 0.011, 0.036}, m.skin, mesh);
  return mesh;
}

Mesh makeThigh(const PersonLook& look, const BodyMaterials& m, double length) {
  const double g = look.girth;
  Mesh mesh;
  addLoft({{-length - 0.03, 0.046 * g, 0.046 * g, 0.0, m.trousers},
           {-length, 0.060 * g, 0.058 * g, 0.004, m.trousers},
           {-0.300, 0.067 * g, 0.065 * g, 0.006, m.trousers},
           {-0.150, 0.082 * g, 0.077 * g, 0.004, m.trousers},
           {0.000, 0.092 * g, 0.083 * g, -0.004, m.trousers},
           {0.055, 0.070 * g, 0.065 * g, -0.006, m.trousers}},
          14, 2.0, mesh);
  return mesh;
}

Mesh makeShin(const PersonLook& look, const BodyMaterials& m, double length) {
  const double g = look.girth;
  Mesh mesh;
  if (look.shorts) {
    addLoft({{-length - 0.01, 0.036, 0.034, 0.0, m.shoes},
             {-length + 0.07, 0.039, 0.037, 0.0, m.skin},
             {-0.240, 0.050 * g, 0.048 * g, -0.014, m.skin},
             {-0.120, 0.055 * g, 0.052 * g, -0.012, m.skin},
             {-0.020, 0.050 * g, 0.049 * g, 0.004, m.skin},
             {0.030, 0.046 * g, 0.046 * g, 0.004, m.skin}},
            14, 2.0, mesh);
  } else {
    addLoft({{-length - 0.01, 0.036, 0.034, 0.0, m.skin},
             {-length + 0.010, 0.038, 0.036, 0.0, m.trousers},
             {-length + 0.012, 0.058, 0.054, -0.004, m.trousers},
             {-0.240, 0.058 * g, 0.055 * g, -0.010, m.trousers},
             {-0.110, 0.062 * g, 0.058 * g, -0.008, m.trousers},
             {0.000, 0.059 * g, 0.057 * g, 0.004, m.trousers},
             {0.030, 0.046 * g, 0.046 * g, 0.004, m.trousers}},
            14, 2.0, mesh);
  }
  return mesh;
}

/// About the ankle: a loft from heel to toe, then laid along x; its rings' x points down.
Mesh makeFoot(const BodyMaterials& m, double ankle) {
  Mesh mesh;
  const auto ring = [&](double along, double half_height, double half_width) {
    return Ring{along, half_height, half_width, ankle - half_height, m.shoes};
  };
  addLoft({ring(-0.078, 0.022, 0.022), ring(-0.066, 0.040, 0.034), ring(-0.020, 0.050, 0.038),
           ring(0.030, 0.046, 0.040), ring(0.080, 0.034, 0.045), ring(0.130, 0.025, 0.048),
           ring(0.170, 0.021, 0.040), ring(0.188, 0.014, 0.024)},
          12, 2.8, mesh);
  return moved(std::move(mesh), Eigen::Isometry3d(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitY())));
}

int addPart(Mesh mesh, double scale, Scene& scene, Model& model) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= static_cast<float>(scale);
  scene.meshes.push_back(std::move(mesh));
  model.visuals.push_back({static_cast<int>(scene.meshes.size()) - 1, Eigen::Isometry3d::Identity()});
  return static_cast<int>(model.visuals.size()) - 1;
}

/// One mesh for the left and the right limb.
void addPair(Mesh mesh, double scale, Scene& scene, Model& model, int (&pair)[2]) {
  pair[0] = addPart(std::move(mesh), scale, scene, model);
  model.visuals.push_back(model.visuals.back());
  pair[1] = pair[0] + 1;
}

}  // namespace

PersonBody addBody(const PersonLook& look, const std::string& name, Scene& scene) {
  // Heights of the joints of a common body [m].
  constexpr double kHip = 0.8925, kKnee = 0.481, kAnkle = 0.08, kShoulder = 1.388, kNeck = 1.475;
  constexpr double kUpperArm = 0.285, kForearm = 0.255;
  const double scale = look.height_m / kCommonHeight_m;
  const double head_scale = std::sqrt(scale);  // heads vary less than bodies
  const BodyMaterials materials = addMaterials(look, name, scene);
  Model model;
  model.name = name;
  PersonBody body;
  body.torso = addPart(makeTorso(look, materials, kHip), scale, scene, model);
  // The crown is at the person's height whatever the head's own size.
  const double chin_above_neck = (kCommonHeight_m - kNeck) * scale / head_scale - 2.0 * kHeadRadii_m.z();
  body.head = addPart(makeHead(look, materials, chin_above_neck), head_scale, scene, model);
  addPair(makeUpperArm(look, materials, kUpperArm), scale, scene, model, body.upper_arm);
  addPair(makeForearm(look, materials, kForearm), scale, scene, model, body.forearm);
  addPair(makeThigh(look, materials, kHip - kKnee), scale, scene, model, body.thigh);
  addPair(makeShin(look, materials, kKnee - kAnkle), scale, scene, model, body.shin);
  addPair(makeFoot(materials, kAnkle), scale, scene, model, body.foot);

  body.height_m = look.height_m;
  body.hip_height_m = kHip * scale;
  body.hip_offset_m = 0.085 * scale;
  body.thigh_m = (kHip - kKnee) * scale;
  body.shin_m = (kKnee - kAnkle) * scale;
  body.ankle_m = kAnkle * scale;
  body.neck_height_m = kNeck * scale;
  body.shoulder_height_m = kShoulder * scale;
  body.shoulder_offset_m = ((look.broad_shoulders ? 0.174 : 0.157) * look.girth + 0.004) * scale;
  body.upper_arm_m = kUpperArm * scale;
  scene.models.push_back(std::move(model));
  body.model = static_cast<int>(scene.models.size()) - 1;
  return body;
}

}  // namespace frugal_nav::sim
