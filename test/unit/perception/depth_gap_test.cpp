// The whole of depth, gap and nearest obstacle, with a network that gives what it is told to.
#include "flat_view.hpp"

#include <algorithm>

#include <gmock/gmock.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

class DepthGapLook : public testing::Test {
 protected:
  DepthGapLook() {
    flat_.boards = {{2.0, -0.3, 0.3, 0.6}};
    view_.stamp = stampFromSeconds(10.0);
    view_.camera = test::flatCamera();
    view_.base_from_optical = test::flatMount();
  }
  void use(DepthGapParams params) {
    gap_ = std::make_unique<DepthGap>(std::make_unique<test::ToldNetwork>(told_), params);
  }
  DepthFrame look() {
    told_->inverse_depth_pm = flat_.inverseDepth();
    if (!keeps_image_) view_.bgr = flat_.image();
    view_.stamp += fromSeconds(0.1);
    return gap_->look(view_);
  }
  /// Points of visual odometry on the grid's cells, without noise.
  void addPoints(int step) {
    const cv::Mat inverse = flat_.inverseDepth();
    view_.points.clear();
    for (int row = 40; row < 110; row += step) {
      for (int column = 4; column < 156; column += step) {
        const Eigen::Vector2d pixel = flat_.rays().toImage({column, row});
        const float depth = 1.0F / inverse.at<float>(row, column);
        const Eigen::Vector2d p =
            view_.odom_from_base *
            Eigen::Vector2d(flat_.rays().point(row, column, depth).head<2>().cast<double>());
        const auto height = static_cast<double>(flat_.rays().heightAt(row, column, depth));
        view_.points.push_back({cv::Point2f(static_cast<float>(pixel.x()), static_cast<float>(pixel.y())),
                                {p.x(), p.y(), height},
                                0.02});
      }
    }
  }

  test::FlatView flat_;
  std::shared_ptr<test::ToldNetwork::Told> told_ = std::make_shared<test::ToldNetwork::Told>();
  std::unique_ptr<DepthGap> gap_ =
      std::make_unique<DepthGap>(std::make_unique<test::ToldNetwork>(told_), DepthGapParams{});
  DepthView view_;
  bool keeps_image_ = false;
};

TEST_F(DepthGapLook, FloorAloneGivesTheMetres) {
  const DepthFrame frame = look();
  EXPECT_EQ(frame.fault, "");
  ASSERT_TRUE(frame.fit.known);
  EXPECT_GT(frame.fit.floor_points, 50);
  EXPECT_EQ(frame.fit.vo_points, 0);
  ASSERT_FALSE(frame.depth_m.empty());
  EXPECT_NEAR(frame.depth_m.at<float>(80, 80), 1.98, 0.08);
  ASSERT_TRUE(frame.obstacle.found);
  EXPECT_NEAR(frame.obstacle.distance_m, 2.0, 0.06);
  EXPECT_NEAR(frame.obstacle.bearing_rad, 0.0, 0.16);
  EXPECT_EQ(frame.obstacle.source, "floor");
  EXPECT_GT(frame.obstacle.sigma_m, 0.0);
  EXPECT_LT(frame.obstacle.sigma_m, 0.2);
}

TEST_F(DepthGapLook, PointsAloneGiveTheMetresByThePapersMethod) {
  DepthGapParams params;
  params.method = "vo";
  use(params);
  EXPECT_TRUE(look().depth_m.empty());
  addPoints(6);
  DepthFrame frame;
  for (int i = 0; i < 5; ++i) frame = look();
  ASSERT_TRUE(frame.fit.known);
  EXPECT_EQ(frame.fit.floor_points, 0);
  EXPECT_NEAR(frame.depth_m.at<float>(80, 80), 1.98, 0.12);
}

TEST_F(DepthGapLook, PointsMendTheNetworkWhereTheyLie) {
  addPoints(4);
  look();
  // From now on the network takes the board for 25 % farther.
  const cv::Mat truth = flat_.inverseDepth();
  test::FlatView wrong = flat_;
  wrong.boards[0].x_m = 2.5;
  wrong.boards[0].right_m *= 1.25;
  wrong.boards[0].left_m *= 1.25;
  for (int i = 0; i < 3; ++i) {
    told_->inverse_depth_pm = wrong.inverseDepth();
    view_.stamp += fromSeconds(0.1);
    const DepthFrame frame = gap_->look(view_);
    EXPECT_NEAR(frame.depth_m.at<float>(80, 80), 1.0F / truth.at<float>(80, 80), 0.12);
  }
}

TEST_F(DepthGapLook, PointsShowWhatTheNetworkDoesNotSee) {
  flat_.boards = {{1.2, -0.1, 0.1, 0.5}};
  flat_.wall_x_m = 2.6;
  addPoints(4);
  // Network, its floor and the colours tell of an empty room.
  test::FlatView empty = flat_;
  empty.boards.clear();
  empty.floor().convertTo(told_->floor, CV_32F, 1.0 / 255.0);
  told_->inverse_depth_pm = empty.inverseDepth();
  view_.bgr = empty.image();
  DepthFrame frame;
  for (int i = 0; i < 3; ++i) {
    view_.stamp += fromSeconds(0.1);
    frame = gap_->look(view_);
  }
  ASSERT_TRUE(frame.obstacle.found);
  EXPECT_NEAR(frame.obstacle.distance_m, 1.2, 0.06);
  EXPECT_EQ(frame.floor.at<uchar>(90, 80), 0);
  // The room's own points pull where the network sees no edge, but not behind the board.
  EXPECT_LT(frame.depth_m.at<float>(80, 80), 1.25F / flat_.inverseDepth().at<float>(80, 80) + 0.01F);
  // Beside the board the floor runs on.
  EXPECT_EQ(frame.floor.at<uchar>(94, 40), 255);
  EXPECT_NEAR(frame.depth_m.at<float>(60, 40), 2.6F, 0.15F);
}

// The network takes the board for 10 % nearer. Its foot mends all of it; at one depth along the optical axis
// from foot to head, 0.5 m at 5 degrees, the head would come out 2 % too near.
TEST_F(DepthGapLook, AFootMendsAThingUpToItsHead) {
  const cv::Mat truth = flat_.inverseDepth();
  told_->inverse_depth_pm = truth.clone();
  told_->inverse_depth_pm.setTo(0.0, flat_.floor());
  told_->inverse_depth_pm = cv::max(truth, 1.1 * told_->inverse_depth_pm);
  view_.bgr = flat_.image();
  DepthFrame frame;
  for (int i = 0; i < 3; ++i) {
    view_.stamp += fromSeconds(0.1);
    frame = gap_->look(view_);
  }
  for (const int row : {66, 75, 85}) {
    EXPECT_NEAR(frame.depth_m.at<float>(row, 80) * truth.at<float>(row, 80), 1.0F, 0.008F) << row;
  }
}

TEST_F(DepthGapLook, PointsOfAWrongScaleShowNothing) {
  flat_.boards.clear();
  flat_.wall_x_m = 2.6;
  look();
  addPoints(4);
  // Visual odometry that takes the robot's way for a third of what it was.
  for (MetricPoint& point : view_.points) {
    const Eigen::Vector3d eye = view_.base_from_optical.translation();
    point.p_odom = eye + (point.p_odom - eye) / 3.0;
  }
  DepthFrame frame;
  for (int i = 0; i < 3; ++i) frame = look();
  EXPECT_NEAR(frame.depth_m.at<float>(60, 80), 2.6F, 0.3F);
  EXPECT_EQ(frame.floor.at<uchar>(100, 80), 255);
  EXPECT_GT(frame.obstacle.found ? frame.obstacle.distance_m : 9.0, 2.0);
}

// On the way without a floor in view points alone would carry the scale off within a second.
TEST_F(DepthGapLook, PointsOfAWrongScaleDoNotCarryTheScaleOff) {
  flat_.boards.clear();
  flat_.wall_x_m = 2.6;
  DepthFrame frame = look();
  const double scale = frame.fit.a;
  flat_.wall_x_m = 0.9;  // its foot is below the image
  addPoints(4);
  for (MetricPoint& point : view_.points) {
    const Eigen::Vector3d eye = view_.base_from_optical.translation();
    point.p_odom = eye + (point.p_odom - eye) / 2.0;
  }
  for (int i = 0; i < 5; ++i) frame = look();
  EXPECT_NEAR(frame.fit.a, scale, 0.2 * scale);
}

TEST_F(DepthGapLook, PointsOnTheFloorKeepItFloor) {
  addPoints(3);
  // The network takes the floor before the board for the board's lower part.
  test::FlatView wrong = flat_;
  wrong.boards[0].x_m = 1.5;
  wrong.boards[0].right_m *= 0.75;
  wrong.boards[0].left_m *= 0.75;
  wrong.floor().convertTo(told_->floor, CV_32F, 1.0 / 255.0);
  view_.bgr = flat_.image();
  DepthFrame frame;
  for (int i = 0; i < 3; ++i) {
    told_->inverse_depth_pm = wrong.inverseDepth();
    view_.stamp += fromSeconds(0.1);
    frame = gap_->look(view_);
  }
  ASSERT_TRUE(frame.obstacle.found);
  EXPECT_NEAR(frame.obstacle.distance_m, 2.0, 0.12);
}

TEST_F(DepthGapLook, AFootThatThePointsContradictDoesNotCount) {
  flat_.boards = {{2.0, -0.3, 0.3, 0.6}};
  addPoints(4);
  std::vector<MetricPoint>& points = view_.points;
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const MetricPoint& point) { return point.p_odom.z() < 0.25; }),
               points.end());
  // By network and floor the board stands at 1.6 m; the points on its upper half lie at 2 m.
  test::FlatView wrong = flat_;
  wrong.boards[0] = {1.6, -0.24, 0.24, 0.56};
  wrong.floor().convertTo(told_->floor, CV_32F, 1.0 / 255.0);
  view_.bgr = wrong.image();
  DepthFrame frame;
  for (int i = 0; i < 3; ++i) {
    told_->inverse_depth_pm = wrong.inverseDepth();
    view_.stamp += fromSeconds(0.1);
    frame = gap_->look(view_);
  }
  EXPECT_NEAR(frame.depth_m.at<float>(60, 80), 2.0F, 0.08F);
}

TEST_F(DepthGapLook, UnscaledIsOneFactor) {
  DepthGapParams params;
  params.method = "unscaled";
  params.unscaled_factor_pm = 2.0;
  told_->b = 0.0;
  use(params);
  EXPECT_NEAR(look().depth_m.at<float>(80, 80), 1.98, 0.03);
}

TEST_F(DepthGapLook, GapIsBesideTheBoard) {
  flat_.boards = {{1.5, -1.5, -0.3, 0.6}, {1.6, 0.4, 1.5, 0.6}};
  look();
  const DepthFrame frame = look();
  ASSERT_TRUE(frame.gap.found) << frame.gap.reason;
  EXPECT_NEAR(frame.gap.width_m, 0.7, 0.1);
  EXPECT_NEAR(frame.gap.depth_m, 1.5, 0.1);
  EXPECT_GT(frame.gap.left_bearing_rad, 0.15);
  EXPECT_LT(frame.gap.right_bearing_rad, -0.12);
}

TEST_F(DepthGapLook, ThePersonWhoIsTheGoalStaysInTheScanButIsNotTheNearest) {
  KnownGoal goal;
  goal.p_odom = {2.05, 0.0};
  goal.above_floor_m = 1.6;
  view_.goal = goal;
  look();
  const DepthFrame frame = look();
  EXPECT_GT(frame.obstacle.found ? frame.obstacle.distance_m : 9.0, 4.0);
  const std::size_t middle = frame.scan.ranges_m.size() / 2;
  EXPECT_NEAR(frame.scan.ranges_m[middle], 2.0, 0.1);
  // Somebody between them is.
  flat_.boards.push_back({1.4, -0.1, 0.1, 0.6});
  flat_.boards[1].colour = {200, 40, 40};
  look();
  EXPECT_NEAR(look().obstacle.distance_m, 1.4, 0.06);
}

TEST_F(DepthGapLook, NothingNearHasNoReason) {
  flat_.boards.clear();
  flat_.wall_x_m = 9.0;
  look();
  const DepthFrame frame = look();
  EXPECT_FALSE(frame.obstacle.found);
  EXPECT_EQ(frame.obstacle.reason, "");
  EXPECT_TRUE(frame.gap.found);
}

TEST_F(DepthGapLook, BadImagesHaveTheirFaultAndItRecovers) {
  const DepthView sound = view_;
  look();
  const auto faultOf = [this] {
    keeps_image_ = true;
    const DepthFrame frame = look();
    EXPECT_FALSE(frame.gap.found);
    EXPECT_EQ(frame.gap.reason, frame.fault);
    EXPECT_FALSE(frame.obstacle.found);
    EXPECT_EQ(frame.obstacle.reason, frame.fault);
    EXPECT_FALSE(frame.scan.ranges_m.empty());
    for (const float range : frame.scan.ranges_m) EXPECT_TRUE(std::isnan(range));
    return frame.fault;
  };
  view_.bgr = cv::Mat();
  EXPECT_THAT(faultOf(), HasSubstr("empty"));
  view_.bgr = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0));
  EXPECT_EQ(faultOf(), "the image is black");
  view_.bgr.setTo(255);
  EXPECT_EQ(faultOf(), "the image is saturated");
  view_.bgr = cv::Mat(480, 640, CV_8UC1, cv::Scalar::all(90));
  EXPECT_THAT(faultOf(), HasSubstr("CV_8UC1"));
  view_.bgr = cv::Mat(480, 480, CV_8UC3, cv::Scalar(90, 80, 70));
  EXPECT_THAT(faultOf(), HasSubstr("480x480"));
  view_.bgr = flat_.image();
  view_.camera.fx = 0.0;
  EXPECT_THAT(faultOf(), HasSubstr("fx = 0"));
  view_.camera = sound.camera;
  view_.odom_from_base.x_m = std::nan("");
  EXPECT_THAT(faultOf(), HasSubstr("odometry"));
  view_.odom_from_base = {};
  view_.base_from_optical.translation().z() = -0.1;
  EXPECT_THAT(faultOf(), HasSubstr("below the floor"));
  view_.base_from_optical = sound.base_from_optical;
  keeps_image_ = false;
  EXPECT_EQ(look().fault, "");
  EXPECT_TRUE(look().obstacle.found);
}

TEST_F(DepthGapLook, ANetworkThatGivesNoNumbersIsAFault) {
  view_.bgr = flat_.image();
  told_->inverse_depth_pm = cv::Mat(120, 160, CV_32FC1, cv::Scalar(std::nan("")));
  EXPECT_THAT(gap_->look(view_).fault, HasSubstr("not finite"));
}

TEST_F(DepthGapLook, TakesResizedImages) {
  keeps_image_ = true;
  view_.bgr = flat_.image({320, 240});
  const DepthFrame frame = look();
  EXPECT_EQ(frame.fault, "");
  EXPECT_NEAR(frame.obstacle.distance_m, 2.0, 0.1);
}

TEST_F(DepthGapLook, AStampBeforeTheLastForgetsTheScale) {
  addPoints(6);
  DepthGapParams params;
  params.method = "vo";
  use(params);
  EXPECT_TRUE(look().fit.known);
  view_.points.clear();
  EXPECT_TRUE(look().fit.known);
  view_.stamp -= fromSeconds(5.0);
  EXPECT_FALSE(look().fit.known);
}

// A network that tells the floor. What it gives for depth is 30 % too far for near things.
class DepthGapOfAFloorNetwork : public DepthGapLook {
 protected:
  DepthFrame lookAtNear(double probability = 0.98) {
    const cv::Mat is_floor = flat_.floor();
    told_->floor = cv::Mat(is_floor.size(), CV_32FC1, cv::Scalar(1.0 - probability));
    told_->floor.setTo(probability, is_floor);
    told_->inverse_depth_pm = flat_.inverseDepth();
    for (int row = 0; row < is_floor.rows; ++row) {
      for (int column = 0; column < is_floor.cols; ++column) {
        float& q = told_->inverse_depth_pm.at<float>(row, column);
        if (is_floor.at<uchar>(row, column) == 0 && q > 0.4F) q /= 1.3F;
      }
    }
    view_.bgr = flat_.image();
    view_.stamp += fromSeconds(0.4);
    return gap_->look(view_);
  }
};

TEST_F(DepthGapOfAFloorNetwork, AThingOfTheFloorsColourStandsWhereItStands) {
  flat_.boards[0].colour = flat_.floor_colour;
  lookAtNear();
  const DepthFrame frame = lookAtNear();
  ASSERT_TRUE(frame.obstacle.found);
  EXPECT_NEAR(frame.obstacle.distance_m, 2.0, 0.08);
  EXPECT_EQ(cv::countNonZero(frame.floor.col(80) != flat_.floor().col(80)), 0);
}

TEST_F(DepthGapOfAFloorNetwork, MayBeToldToGoByColour) {
  DepthGapParams params;
  params.use_network_floor = false;
  use(params);
  const DepthFrame frame = lookAtNear(0.02);  // all wrong
  EXPECT_GT(cv::countNonZero(frame.floor.col(10) & flat_.floor().col(10)), 25);
}

TEST_F(DepthGapOfAFloorNetwork, RemembersWhereAThingStoodWhenItsFootLeavesTheView) {
  for (int i = 0; i <= 9; ++i) {
    flat_.boards[0].x_m = 1.6 - 0.1 * i;
    view_.odom_from_base.x_m = 0.1 * i;
    const DepthFrame frame = lookAtNear();
    ASSERT_TRUE(frame.obstacle.found) << i;
    EXPECT_NEAR(frame.obstacle.distance_m, flat_.boards[0].x_m, 0.12) << i;
  }
}

TEST_F(DepthGapOfAFloorNetwork, NumbersThatAreNoneAreAFault) {
  view_.bgr = flat_.image();
  told_->inverse_depth_pm = flat_.inverseDepth();
  told_->floor = cv::Mat(120, 160, CV_32FC1, cv::Scalar(std::nan("")));
  EXPECT_THAT(gap_->look(view_).fault, HasSubstr("not finite"));
}

}  // namespace
}  // namespace frugal_nav
