// The floor: by colour, by its line, and where things stood on it.
#include "flat_view.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/contact_memory.hpp>
#include <frugal_nav/perception/floor_contact.hpp>
#include <frugal_nav/perception/floor_mask.hpp>

namespace frugal_nav {
namespace {

using State = FloorContact::State;

/// Share of the cells of a region in which a mask is set.
double share(const cv::Mat& mask, const cv::Rect& region) {
  return static_cast<double>(cv::countNonZero(mask(region))) / region.area();
}

class Floor : public testing::Test {
 protected:
  cv::Mat small() const {
    cv::Mat image;
    cv::resize(view_.image(), image, view_.rays().grid(), 0.0, 0.0, cv::INTER_AREA);
    return image;
  }
  std::vector<FloorContact> contacts(const cv::Mat& mask) const {
    auto found = findFloorContacts(floorEvidence(mask, FloorContactParams{}), view_.inverseDepth(),
                                   view_.rays(), FloorContactParams{});
    refineContacts(view_.image(), view_.rays(), FloorContactParams{}, found);
    return found;
  }
  /// Depth along the optical axis of the floor where a board stands, at its middle.
  static double footDepth(double x_m) {
    const double pitch = 5.0 * M_PI / 180.0;
    return x_m * std::cos(pitch) - 0.4 * std::sin(pitch);
  }

  test::FlatView view_;
};

TEST_F(Floor, RaysMeetItWhereHeightAndPitchSay) {
  // A point of the floor 2 m ahead, projected and looked at again.
  const Eigen::Vector3d p_optical = test::flatMount().inverse() * Eigen::Vector3d(2.0, 0.3, 0.0);
  const auto pixel = view_.rays().camera().project(p_optical);
  ASSERT_TRUE(pixel);
  const Eigen::Vector3d ray = view_.rays().rayThrough(*pixel);
  EXPECT_NEAR(0.4 / -ray.z(), p_optical.z(), 1e-9);
  const Eigen::Vector2d cell = view_.rays().toGrid(*pixel);
  EXPECT_NEAR((view_.rays().toImage(cell) - *pixel).norm(), 0.0, 1e-9);
  EXPECT_NEAR(1.0F / view_.rays().inverseFloorDepth(cvRound(cell.y()), cvRound(cell.x())), p_optical.z(),
              0.1);
  // The horizon lies tan(5 deg) * 532 px = 46.5 px below the middle, 239.5: row 71 of the grid is the first
  // whose middle, 285.5 px + 1.5, looks below it.
  EXPECT_EQ(view_.rays().firstRowBelowHorizon(80), 72);
}

TEST_F(Floor, ACameraPitchedUpSeesAHeadFartherThanItsFoot) {
  view_.boards = {{2.0, -0.3, 0.3, 0.6}};
  const cv::Mat inverse = view_.inverseDepth();
  const float head = view_.rays().uprightDepth(70, 95, 80, 1.0F / inverse.at<float>(95, 80));
  EXPECT_NEAR(head, 1.0F / inverse.at<float>(70, 80), 1e-4F);
  EXPECT_GT(head * inverse.at<float>(95, 80), 1.01F);
}

TEST_F(Floor, IsTheClusterAtTheBottomOfTheImage) {
  view_.boards = {{2.0, -0.2, 0.2, 0.6}};
  FloorMask mask{FloorMaskParams{}};
  const cv::Mat found = mask.find(small(), view_.rays());
  EXPECT_GT(share(found, {0, 100, 160, 20}), 0.99);
  EXPECT_LT(share(found, {72, 75, 15, 10}), 0.01);  // the board
  EXPECT_LT(share(found, {0, 0, 160, 70}), 0.01);   // above the horizon
}

TEST_F(Floor, OfItsColourButNotConnectedIsNone) {
  view_.boards = {{2.0, -3.0, 3.0, 0.25}, {2.0, -3.0, 3.0, 0.15}};
  view_.boards[0].colour = view_.floor_colour;  // a stripe of the floor's colour over one of another
  view_.boards[1].colour = {40, 40, 200};
  FloorMask mask{FloorMaskParams{}};
  EXPECT_LT(share(mask.find(small(), view_.rays()), {20, 78, 120, 3}), 0.01);
}

TEST_F(Floor, StaysTheSameColourWhenAThingFillsTheStrip) {
  FloorMask mask{FloorMaskParams{}};
  view_.boards = {{2.0, -0.2, 0.2, 0.6}};
  mask.find(small(), view_.rays());
  view_.boards = {{0.6, -0.25, 0.25, 0.6}};
  const cv::Mat found = mask.find(small(), view_.rays(), view_.floor());
  EXPECT_LT(share(found, {60, 90, 40, 30}), 0.01);
  EXPECT_GT(share(found, {0, 100, 15, 20}), 0.99);
}

// A board 2 m ahead: within a millimetre or two of the true foot once the line is sharpened, a row of the
// image being 2.6 cm there and the line half a row.
TEST_F(Floor, LineTellsTheDistanceOfWhatStandsOnIt) {
  for (const double x_m : {1.3, 1.8, 2.4}) {
    view_.boards = {{x_m, -0.3, 0.3, 0.6}};
    const auto found = contacts(view_.floor());
    ASSERT_EQ(found[80].state, State::kContact) << x_m;
    const double row_m = x_m * x_m / (0.4 * 532.0);
    EXPECT_NEAR(found[80].depth_m, footDepth(x_m), row_m + 0.005) << x_m;
    EXPECT_GT(found[80].sigma_m, 0.5 * row_m);
  }
}

// A network blurs the line by some cells: 12 px are 1.5 of the line's sigma. Tiles end nearer to where it is
// then looked for, but change less. A pixel is 2 cm there.
TEST_F(Floor, ALineSomeCellsOffComesBackToTheFoot) {
  view_.boards = {{2.0, -0.3, 0.3, 0.6}};
  view_.tile_m = 0.3;
  view_.floor_colour_2 = {100, 130, 110};
  for (const int off : {-3, 3}) {
    auto found = findFloorContacts(floorEvidence(view_.floor(), FloorContactParams{}), view_.inverseDepth(),
                                   view_.rays(), FloorContactParams{});
    found[80].row += off;
    refineContacts(view_.image(), view_.rays(), FloorContactParams{}, found);
    EXPECT_NEAR(found[80].depth_m, footDepth(2.0), 0.02) << off;
  }
}

TEST_F(Floor, AThingOfItsColourIsNone) {
  view_.boards = {{1.6, -0.3, 0.3, 0.6}};
  const cv::Mat all_floor(view_.rays().grid(), CV_8UC1, cv::Scalar(255.0));
  const auto found = contacts(all_floor);
  ASSERT_EQ(found[80].state, State::kContact);
  EXPECT_NEAR(found[80].depth_m, footDepth(1.6), 0.25);  // by the depth's profile alone, which is flat there
}

TEST_F(Floor, APatternOnItIsFloor) {
  view_.floor_colour_2 = {40, 40, 200};
  FloorMask mask{FloorMaskParams{}};
  const auto found = contacts(mask.find(small(), view_.rays()));
  // All that stands there is the wall at 5 m.
  int nearer = 0;
  for (const FloorContact& contact : found)
    nearer += contact.state == State::kContact && contact.depth_m < 4.0;
  EXPECT_EQ(nearer, 0);
}

TEST_F(Floor, IsHiddenByWhatIsTooNearForItsFootToBeSeen) {
  view_.boards = {{0.7, -0.2, 0.2, 0.6}};
  const auto found = contacts(view_.floor());
  EXPECT_EQ(found[80].state, State::kHidden);
  EXPECT_EQ(found[3].state, State::kContact);
  EXPECT_EQ(cv::countNonZero(floorOf(found, view_.rays()).col(80)), 0);
}

TEST_F(Floor, ColourAloneDecidesWhileNoScaleIsKnown) {
  view_.boards = {{1.8, -0.3, 0.3, 0.6}};
  const auto found = findFloorContacts(floorEvidence(view_.floor(), FloorContactParams{}), cv::Mat(),
                                       view_.rays(), FloorContactParams{});
  EXPECT_EQ(found[80].state, State::kContact);
  const int foot = found[80].row;
  EXPECT_EQ(view_.floor().at<uchar>(foot, 80), 0);
  EXPECT_EQ(view_.floor().at<uchar>(foot + 1, 80), 255);
}

// Seen at 1.6 m, driven 0.9 m toward: its foot is below the image, and memory says 0.7 m.
TEST_F(Floor, FeetAreRememberedWhenTheyLeaveTheView) {
  ContactMemory memory{ContactMemoryParams{}};
  view_.boards = {{1.6, -0.3, 0.3, 0.6}};
  const Stamp stamp = stampFromSeconds(5.0);
  memory.update(stamp, {1.0, 2.0, M_PI / 2}, view_.rays(), contacts(view_.floor()));
  EXPECT_TRUE(memory.recall(stamp, {1.0, 2.0, M_PI / 2}, view_.rays()).empty());  // the image itself tells
  const Pose2 nearer{1.0, 2.9, M_PI / 2};
  const auto known = memory.recall(stamp + fromSeconds(3.0), nearer, view_.rays());
  ASSERT_GT(known.size(), 20U);
  for (const DepthAnchor& anchor : known) {
    EXPECT_NEAR(1.0 / anchor.inverse_depth_pm, 0.7, 0.06);  // along an axis 5 degrees up, at some height
    EXPECT_LT(anchor.relative_sigma, 0.08);
  }
  EXPECT_TRUE(memory.recall(stamp + fromSeconds(60.0), nearer, view_.rays()).empty());
  // Back where the foot would be in view, nothing stands there any more.
  view_.boards.clear();
  memory.update(stamp + fromSeconds(4.0), {1.0, 2.0, M_PI / 2}, view_.rays(), contacts(view_.floor()));
  EXPECT_TRUE(memory.recall(stamp + fromSeconds(5.0), nearer, view_.rays()).empty());
}

}  // namespace
}  // namespace frugal_nav
