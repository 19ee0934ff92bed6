#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/training_scene.hpp>
#include <frugal_nav/eval/view_truth.hpp>
#include <frugal_nav/perception/head_range.hpp>
#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kFocal_px = 400.0;
constexpr double kDistance_m = 3.0;

/// A camera at the origin's height 1.6 m that looks along x.
Viewpoint levelView() {
  Viewpoint view;
  view.size_px = {400, 300};
  view.camera_matrix = cv::Matx33d(kFocal_px, 0.0, 199.5, 0.0, kFocal_px, 149.5, 0.0, 0.0, 1.0);
  view.world_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  view.world_from_optical.translation().z() = 1.6;
  return view;
}

void addBox(const Eigen::Vector3d& size_m, const Eigen::Vector3d& p, sim::Scene& scene) {
  sim::Model model;
  model.world_from_model.translation() = p;
  model.visuals.push_back({static_cast<int>(scene.meshes.size()), Eigen::Isometry3d::Identity()});
  sim::Mesh mesh = sim::makeBox(size_m);
  mesh.triangle_material.assign(mesh.triangles.size(), -1);
  scene.meshes.push_back(mesh);
  scene.models.push_back(model);
}

/// The shipped robot's: 0.4 m high, 5 degrees up, with its lens.
Viewpoint lowView() {
  Viewpoint view = levelView();
  view.distortion = {0.10, -0.22, 0.0005, -0.0005, 0.05};
  view.world_from_optical.linear() =
      Eigen::AngleAxisd(-5.0 * M_PI / 180.0, Eigen::Vector3d::UnitY()) * view.world_from_optical.linear();
  view.world_from_optical.translation().z() = 0.4;
  return view;
}

struct Seen {
  sim::Scene scene;
  std::vector<sim::PersonBody> people;
  ViewTruth truth;
  std::vector<PersonBox> boxes;
};

/// A person somewhere, standing.
Seen lookAtPerson(std::uint64_t appearance, const Pose2& world_from_person, const Viewpoint& view,
                  double board_m = 0.0) {
  Seen seen;
  sim::Person person;
  person.appearance = appearance;
  person.waypoints.push_back({0.0, world_from_person});
  seen.scene.people.push_back(person);
  seen.people = sim::addPeople(seen.scene);
  if (board_m > 0.0) addBox({0.02, 2.0, board_m}, {1.5, 0.0, 0.5 * board_m}, seen.scene);
  const sim::RayTracer tracer(seen.scene);
  seen.truth = traceTruth(tracer, view);
  seen.boxes = findPeople(seen.truth, seen.scene, seen.people, view);
  return seen;
}

/// A person 3 m ahead who looks at the camera, and perhaps a board between them up to a height.
Seen lookAtPerson(std::uint64_t appearance, double board_m) {
  return lookAtPerson(appearance, {kDistance_m, 0.0, M_PI}, levelView(), board_m);
}

const PersonBox* find(const std::vector<PersonBox>& boxes, bool head) {
  for (const PersonBox& box : boxes) {
    if (box.is_head == head) return &box;
  }
  return nullptr;
}

TEST(ViewTruth, DepthIsAlongTheOpticalAxis) {
  sim::Scene scene;
  addBox({0.2, 40.0, 40.0}, {2.1, 0.0, 0.0}, scene);  // a wall whose face is 2 m ahead
  const sim::RayTracer tracer(scene);
  const ViewTruth truth = traceTruth(tracer, levelView());
  // Floats of a few metres: 1e-4 is far above their rounding.
  for (const cv::Point& p : {cv::Point(0, 0), cv::Point(200, 150), cv::Point(399, 299)})
    EXPECT_NEAR(truth.depth_m.at<float>(p), 2.0F, 1e-4F);
}

TEST(ViewTruth, NothingIsInfinitelyFar) {
  sim::Scene scene;
  addBox({0.1, 0.1, 0.1}, {-2.0, 0.0, 1.6}, scene);  // behind
  const sim::RayTracer tracer(scene);
  const ViewTruth truth = traceTruth(tracer, levelView());
  EXPECT_TRUE(std::isinf(truth.depth_m.at<float>(100, 100)));
  EXPECT_EQ(truth.model.at<int>(100, 100), -1);
}

TEST(ViewTruth, HeadIsAsHighAsItsSkullWhateverTheHair) {
  for (std::uint64_t appearance = 1; appearance <= 12; ++appearance) {
    const Seen seen = lookAtPerson(appearance, 0.0);
    const PersonBox* head = find(seen.boxes, true);
    ASSERT_NE(head, nullptr);
    // 0.236 m for a person of 1.75 m, growing with the root of the height; seen level within 5 degrees, which
    // takes less than 0.3 % off; the head's middle is at most 0.05 m ahead of the feet (2 %).
    const double skull_m = 0.236 * std::sqrt(seen.people[0].height_m / 1.75);
    const double expected_px = kFocal_px * skull_m / kDistance_m;
    EXPECT_NEAR(head->box_px.height, expected_px, 0.025 * expected_px) << "appearance " << appearance;
    EXPECT_NEAR(head->distance_m, kDistance_m, 0.05);
    EXPECT_GT(head->visible, kWholeHead);
  }
}

// From below and from all sides, where hair and neck hang behind the chin or hide it.
TEST(ViewTruth, HeadRangeFitsTheBoxOfAHead) {
  const Viewpoint view = lowView();
  Pinhole camera;
  camera.width_px = view.size_px.width;
  camera.height_px = view.size_px.height;
  camera.fx = camera.fy = kFocal_px;
  camera.cx = view.camera_matrix(0, 2);
  camera.cy = view.camera_matrix(1, 2);
  camera.k1 = view.distortion[0];
  camera.k2 = view.distortion[1];
  camera.p1 = view.distortion[2];
  camera.p2 = view.distortion[3];
  camera.k3 = view.distortion[4];
  int whole = 0;
  for (std::uint64_t appearance = 1; appearance <= 12; ++appearance) {
    const double turned_rad = 0.5 * static_cast<double>(appearance);
    const Pose2 place{3.6, 0.1 * static_cast<double>(appearance) - 0.6, turned_rad};
    const Seen seen = lookAtPerson(appearance, place, view);
    const PersonBox* head = find(seen.boxes, true);
    ASSERT_NE(head, nullptr);
    if (head->visible < kWholeHead) continue;
    ++whole;
    HeadRangeParams params;
    const double size = std::sqrt(seen.people[0].height_m / 1.75);
    params.head_height_m = 0.236 * size;
    params.head_depth_m = 0.20 * size;
    const HeadSighting sighting =
        HeadRange(params, camera, view.world_from_optical).locate({0, "head", 1.0, head->box_px});
    ASSERT_EQ(sighting.status, HeadSighting::Status::kGood);
    // HeadRange takes the box's middle for the head's, and its small extent for an angle: 0.1 % each; a
    // column too far left or right by half a pixel moves the lens' bend by less.
    EXPECT_NEAR(sighting.range_m / head->distance_m, 1.0, 0.005) << "appearance " << appearance;
  }
  EXPECT_GE(whole, 10);
}

TEST(ViewTruth, HiddenPartsAreNotVisible) {
  EXPECT_EQ(find(lookAtPerson(3, 2.5).boxes, true), nullptr);  // all hidden
  const Seen open = lookAtPerson(3, 0.0);
  const PersonBox* whole = find(open.boxes, true);
  ASSERT_NE(whole, nullptr);
  // A board whose upper edge is seen at the head's middle: on the line from the camera at half of the
  // distance.
  const double middle_m = open.people[0].height_m - 0.118;
  const PersonBox* half = nullptr;
  const Seen covered = lookAtPerson(3, 0.5 * (1.6 + middle_m));
  half = find(covered.boxes, true);
  ASSERT_NE(half, nullptr);
  EXPECT_NEAR(half->visible / whole->visible, 0.5, 0.15);  // heads are wider above their middle
  EXPECT_NEAR(half->box_px.height / whole->box_px.height, 0.5, 0.1);
}

TEST(TrainingScene, RefusesSeedsOfEvaluationAndTuning) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{99999}, std::uint64_t{999999}}) {
    try {
      makeTrainingScene(seed, {});
      FAIL() << "seed " << seed << " was accepted";
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("seeds from 1000000"));
    }
  }
}

TEST(TrainingScene, SameSeedGivesTheSameViewAndSeesSomething) {
  const TrainingStock stock = readTrainingStock(FRUGAL_NAV_SOURCE_DIR "/worlds");
  const auto draw = [&stock](std::uint64_t seed) {
    const TrainingScene place = makeTrainingScene(seed, stock);
    const sim::RayTracer tracer(place.scene);
    Random random(seed, "view");
    const auto view = drawTrainingView(place, tracer, 64, random);
    EXPECT_TRUE(view.has_value());
    Viewpoint viewpoint;
    viewpoint.size_px = {64, 48};
    viewpoint.camera_matrix = cv::Matx33d(60.0, 0.0, 31.5, 0.0, 60.0, 23.5, 0.0, 0.0, 1.0);
    if (view) viewpoint.world_from_optical = view->world_from_optical;
    return traceTruth(tracer, viewpoint).depth_m;
  };
  const cv::Mat first = draw(kFirstTrainingSeed + 7);
  EXPECT_EQ(cv::countNonZero(first != draw(kFirstTrainingSeed + 7)), 0);
  EXPECT_GT(cv::countNonZero(first != draw(kFirstTrainingSeed + 8)), 1000);
  double nearest = 0.0;
  cv::minMaxLoc(first, &nearest);
  EXPECT_GT(nearest, 0.05);
}

}  // namespace
}  // namespace frugal_nav::eval
