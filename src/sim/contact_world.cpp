#include <algorithm>
#include <cmath>
#include <utility>

#include <btBulletCollisionCommon.h>

#include <frugal_nav/sim/contact_world.hpp>

namespace frugal_nav::sim {
namespace {

// Bullet's shapes are rounded by a margin, four centimetres unless told otherwise. This one is below what
// counts.
constexpr btScalar kMargin_m = 1e-4F;
// A search reaches at most this far: beyond it the clearance found saves no more queries.
constexpr double kLongestSearch_m = 0.5;
constexpr double kShortestSearch_m = 0.02;

btVector3 toBullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform toBullet(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const btQuaternion rotation(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                              static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w()));
  return btTransform(rotation, toBullet(Eigen::Vector3d(pose.translation())));
}

Eigen::Vector3d fromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Isometry3d lifted(const Pose2& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  result.translation() = Eigen::Vector3d(pose.x_m, pose.y_m, 0.0);
  return result;
}

std::unique_ptr<btConvexShape> makeBox(const Eigen::Vector3d& size_m) {
  auto shape = std::make_unique<btBoxShape>(toBullet(Eigen::Vector3d(size_m / 2.0)));
  shape->setMargin(kMargin_m);
  return shape;
}

std::unique_ptr<btConvexShape> makeCylinder(double radius_m, double length_m) {
  auto shape =
      std::make_unique<btCylinderShapeZ>(toBullet(Eigen::Vector3d(radius_m, radius_m, length_m / 2.0)));
  shape->setMargin(kMargin_m);
  return shape;
}

std::unique_ptr<btConvexShape> makeSphere(double radius_m) {
  return std::make_unique<btSphereShape>(static_cast<btScalar>(radius_m));
}

std::unique_ptr<btConvexShape> makeShape(const RobotShape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) return makeBox(box->size_m);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry))
    return makeCylinder(cylinder->radius_m, cylinder->length_m);
  return makeSphere(std::get<SphereShape>(shape.geometry).radius_m);
}

/// The nearest contact point of a pair.
struct Nearest : btCollisionWorld::ContactResultCallback {
  explicit Nearest(const btCollisionObject* robot_part) : part(robot_part) {}

  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    if (found && point.getDistance() >= distance_m) return 0.0F;
    const bool robot_first = first->getCollisionObject() == part;
    found = true;
    distance_m = point.getDistance();
    p_other = robot_first ? point.getPositionWorldOnB() : point.getPositionWorldOnA();
    normal = robot_first ? point.m_normalWorldOnB : -point.m_normalWorldOnB;
    return 0.0F;
  }

  const btCollisionObject* part;
  bool found = false;
  btScalar distance_m = 0.0F;
  btVector3 p_other{0.0F, 0.0F, 0.0F};
  btVector3 normal{1.0F, 0.0F, 0.0F};
};

struct ProxyCollector : btBroadphaseAabbCallback {
  bool process(const btBroadphaseProxy* proxy) override {
    objects.push_back(static_cast<btCollisionObject*>(proxy->m_clientObject));
    return true;
  }
  std::vector<btCollisionObject*> objects;
};

}  // namespace

struct ContactWorld::Impl {
  struct Solid {
    int model;
    int collision;
    std::unique_ptr<btCollisionObject> object;
  };
  struct Part {
    std::string link;
    Eigen::Isometry3d base_from_shape;
    std::unique_ptr<btConvexShape> shape;
    std::unique_ptr<btCollisionObject> object;
  };

  btCollisionShape* addShape(const Scene& scene, const Model& model, const Collision& collision);
  void addMesh(const Mesh& mesh, const Eigen::Isometry3d& world_from_mesh);
  void addSolid(const Scene& scene, int model, int collision);
  double place(Solid& solid, const Eigen::Isometry3d& world_from_solid);
  bool isClear(const Pose2& pose, double within_m) const;
  bool isAsSearched(const Pose2& pose, double within_m) const;
  std::vector<Proximity> search(const Pose2& pose, double reach_m);

  // The world goes first when this is destroyed: it still looks at its objects then.
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  std::vector<std::unique_ptr<btTriangleMesh>> meshes;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<Solid> solids;
  std::vector<std::vector<std::size_t>> solids_of_model;
  std::vector<Part> parts;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};

  double robot_reach_m = 0.0;  ///< of any point of the robot from the axis it turns about
  // What the last search found: nothing nearer than clear_m to the robot at searched_from but what is in
  // found.
  Pose2 searched_from;
  std::vector<Proximity> last_found;
  double last_reach_m = -1.0;
  double clear_m = -1.0;
  std::vector<double> model_moved_m;  ///< since the last search
  double most_moved_m = 0.0;
};

void ContactWorld::Impl::addMesh(const Mesh& mesh, const Eigen::Isometry3d& world_from_mesh) {
  auto triangles = std::make_unique<btTriangleMesh>();
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    bool is_floor = true;
    btVector3 corners[3];
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d p = mesh.vertices[static_cast<std::size_t>(triangle[i])].cast<double>();
      corners[i] = toBullet(p);
      is_floor = is_floor && (world_from_mesh * p).z() <= kFloorHeight_m;
    }
    if (!is_floor) triangles->addTriangle(corners[0], corners[1], corners[2]);
  }
  meshes.push_back(std::move(triangles));
}

btCollisionShape* ContactWorld::Impl::addShape(const Scene& scene, const Model& model,
                                               const Collision& collision) {
  const bool is_mesh = collision.kind == Collision::Kind::kMesh;
  const Eigen::Isometry3d world_from_shape = model.world_from_model * collision.model_from_collision;
  const bool known_mesh = collision.mesh >= 0 && collision.mesh < static_cast<int>(scene.meshes.size());
  if (is_mesh ? !known_mesh : !collision.size_m.allFinite()) {
    throw ConfigError("world \"" + scene.name + "\": model \"" + model.name +
                      "\" has a collision shape without a mesh or with a size that is no number");
  }
  std::unique_ptr<btCollisionShape> shape;
  const Eigen::Vector3d& size = collision.size_m;
  if (is_mesh) {
    addMesh(scene.meshes[static_cast<std::size_t>(collision.mesh)], world_from_shape);
    if (meshes.back()->getNumTriangles() == 0) return nullptr;
    shape = std::make_unique<btBvhTriangleMeshShape>(meshes.back().get(), true);
    shape->setMargin(kMargin_m);
  } else if (collision.kind == Collision::Kind::kPlane) {
    if ((world_from_shape.linear() * size).z() > 0.7 * size.norm()) return nullptr;  // a floor
    shape = std::make_unique<btStaticPlaneShape>(toBullet(Eigen::Vector3d(size.normalized())), 0.0F);
    shape->setMargin(kMargin_m);
  } else if (!((collision.kind == Collision::Kind::kSphere ? size.x() : size.minCoeff()) > 0.0)) {
    throw ConfigError("world \"" + scene.name + "\": model \"" + model.name +
                      "\" has a collision shape whose size is not positive");
  } else if (collision.kind == Collision::Kind::kBox) {
    shape = makeBox(size);
  } else if (collision.kind == Collision::Kind::kCylinder) {
    shape = makeCylinder(size.x(), size.z());
  } else {
    shape = makeSphere(size.x());
  }
  shapes.push_back(std::move(shape));
  return shapes.back().get();
}

void ContactWorld::Impl::addSolid(const Scene& scene, int model, int collision) {
  const Model& owner = scene.models[static_cast<std::size_t>(model)];
  const Collision& solid = owner.collisions[static_cast<std::size_t>(collision)];
  btCollisionShape* shape = addShape(scene, owner, solid);
  if (shape == nullptr) return;
  auto object = std::make_unique<btCollisionObject>();
  object->setCollisionShape(shape);
  object->setWorldTransform(toBullet(owner.world_from_model * solid.model_from_collision));
  object->setUserIndex(model);
  world.addCollisionObject(object.get(), btBroadphaseProxy::StaticFilter, 0);
  solids_of_model[static_cast<std::size_t>(model)].push_back(solids.size());
  solids.push_back({model, collision, std::move(object)});
}

double ContactWorld::Impl::place(Solid& solid, const Eigen::Isometry3d& world_from_solid) {
  const btTransform before = solid.object->getWorldTransform();
  const btTransform after = toBullet(world_from_solid);
  btVector3 centre;
  btScalar radius = 0.0F;
  solid.object->getCollisionShape()->getBoundingSphere(centre, radius);
  btScalar turned = 0.0F;  // the Frobenius norm of the rotations' difference bounds how far a point turns
  for (int row = 0; row < 3; ++row) {
    turned += (after.getBasis().getRow(row) - before.getBasis().getRow(row)).length2();
  }
  solid.object->setWorldTransform(after);
  world.updateSingleAabb(solid.object.get());
  return static_cast<double>((after * centre - before * centre).length() + radius * std::sqrt(turned));
}

bool ContactWorld::Impl::isClear(const Pose2& pose, double within_m) const {
  const double robot_moved_m = distance(searched_from, pose) +
                               std::abs(angleBetween(searched_from.yaw_rad, pose.yaw_rad)) * robot_reach_m;
  return clear_m - robot_moved_m - most_moved_m > within_m;
}

bool ContactWorld::Impl::isAsSearched(const Pose2& pose, double within_m) const {
  return within_m <= last_reach_m && most_moved_m == 0.0 && pose.x_m == searched_from.x_m &&
         pose.y_m == searched_from.y_m && pose.yaw_rad == searched_from.yaw_rad;
}

std::vector<Proximity> ContactWorld::Impl::search(const Pose2& pose, double reach_m) {
  const Eigen::Isometry3d world_from_base = lifted(pose);
  const btVector3 reach(static_cast<btScalar>(reach_m), static_cast<btScalar>(reach_m),
                        static_cast<btScalar>(reach_m));
  std::vector<Proximity> nearest;
  for (Part& part : parts) {
    part.object->setWorldTransform(toBullet(world_from_base * part.base_from_shape));
    btVector3 low, high;
    part.shape->getAabb(part.object->getWorldTransform(), low, high);
    ProxyCollector candidates;
    broadphase.aabbTest(low - reach, high + reach, candidates);
    for (btCollisionObject* object : candidates.objects) {
      btVector3 solid_low, solid_high;
      object->getCollisionShape()->getAabb(object->getWorldTransform(), solid_low, solid_high);
      if (solid_high.z() <= kFloorHeight_m) continue;
      Nearest pair(part.object.get());
      pair.m_closestDistanceThreshold = static_cast<btScalar>(reach_m);
      world.contactPairTest(part.object.get(), object, pair);
      if (!pair.found || pair.distance_m > reach_m) continue;
      const int model = object->getUserIndex();
      const auto place = std::lower_bound(nearest.begin(), nearest.end(), model,
                                          [](const Proximity& p, int index) { return p.model < index; });
      const Proximity found{model, part.link, fromBullet(pair.p_other), fromBullet(pair.normal),
                            static_cast<double>(pair.distance_m)};
      if (place == nearest.end() || place->model != model) {
        nearest.insert(place, found);
      } else if (found.distance_m < place->distance_m) {
        *place = found;
      }
    }
  }
  return nearest;
}

ContactWorld::ContactWorld(const Scene& scene, const RobotModel& robot) : impl_(std::make_unique<Impl>()) {
  impl_->solids_of_model.resize(scene.models.size());
  impl_->model_moved_m.resize(scene.models.size(), 0.0);
  for (std::size_t model = 0; model < scene.models.size(); ++model) {
    for (std::size_t i = 0; i < scene.models[model].collisions.size(); ++i) {
      impl_->addSolid(scene, static_cast<int>(model), static_cast<int>(i));
    }
  }
  for (const RobotShape& shape : robot.collisions) {
    Impl::Part part{shape.link, shape.base_from_shape, makeShape(shape),
                    std::make_unique<btCollisionObject>()};
    part.object->setCollisionShape(part.shape.get());
    btVector3 centre;
    btScalar radius = 0.0F;
    part.shape->getBoundingSphere(centre, radius);
    impl_->robot_reach_m =
        std::max(impl_->robot_reach_m,
                 shape.base_from_shape.translation().head<2>().norm() + static_cast<double>(radius));
    impl_->parts.push_back(std::move(part));
  }
}

ContactWorld::~ContactWorld() = default;

void ContactWorld::updateModel(const Scene& scene, int model) {
  const auto index = static_cast<std::size_t>(model);
  const Model& owner = scene.models.at(index);
  double moved_m = 0.0;
  for (const std::size_t i : impl_->solids_of_model[index]) {
    Impl::Solid& solid = impl_->solids[i];
    const Collision& collision = owner.collisions[static_cast<std::size_t>(solid.collision)];
    moved_m = std::max(moved_m, impl_->place(solid, owner.world_from_model * collision.model_from_collision));
  }
  impl_->model_moved_m[index] += moved_m;
  impl_->most_moved_m = std::max(impl_->most_moved_m, impl_->model_moved_m[index]);
}

std::vector<Proximity> ContactWorld::near(const Pose2& world_from_base, double within_m) {
  if (impl_->isClear(world_from_base, within_m)) return {};
  // Look a little farther than the last clearance: far in the open, where it saves searches; short in a
  // crowd, where each pair costs.
  if (!impl_->isAsSearched(world_from_base, within_m)) {
    const double reach_m = std::clamp(2.0 * impl_->clear_m, within_m + kShortestSearch_m,
                                      std::max(kLongestSearch_m, within_m + kShortestSearch_m));
    impl_->last_found = impl_->search(world_from_base, reach_m);
    impl_->searched_from = world_from_base;
    impl_->last_reach_m = impl_->clear_m = reach_m;
    for (const Proximity& p : impl_->last_found) impl_->clear_m = std::min(impl_->clear_m, p.distance_m);
    std::fill(impl_->model_moved_m.begin(), impl_->model_moved_m.end(), 0.0);
    impl_->most_moved_m = 0.0;
  }
  std::vector<Proximity> nearest = impl_->last_found;
  nearest.erase(std::remove_if(nearest.begin(), nearest.end(),
                               [within_m](const Proximity& p) { return p.distance_m > within_m; }),
                nearest.end());
  return nearest;
}

}  // namespace frugal_nav::sim
