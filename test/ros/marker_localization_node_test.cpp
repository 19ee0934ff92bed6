#include "../unit/perception/marker_view.hpp"
#include "camera_graph.hpp"

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <thread>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/SetBool.h>
#include <support/temp_folder.hpp>
#include <tf2_msgs/TFMessage.h>

#include <frugal_nav/MarkerObservationArray.h>
#include <frugal_nav/SetPose.h>
#include <frugal_nav/ros/marker_localization_node.hpp>
#include <frugal_nav/ros/marker_messages.hpp>

namespace frugal_nav {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using PoseMessage = geometry_msgs::PoseWithCovarianceStamped;

const std::string kMap = std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/marker_wall.yaml";
const Pose2 kMapFromOdom{1.6, 0.2, 0.1};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A robot before the wall of test/data/marker_wall.yaml, its odometry at 20 Hz with an IMU beside it. The
/// node runs in this process, anew for each test.
class MarkerLocalizationNodeTest : public testing::Test {
 protected:
  static int count() {
    static int tests = 0;
    return ++tests;
  }
  void start() {
    pnh_.setParam("marker_map", kMap);
    node_ = std::make_unique<MarkerLocalizationNode>(graph_.nh, pnh_);
    ASSERT_TRUE(graph_.connect() && test::waitForSubscriber(imu_pub_));
    ASSERT_TRUE(observations_.waitForPublisher() && poses_.waitForPublisher() && tf_.waitForPublisher());
    graph_.publish(graph_.info());
  }
  /// Odometry and IMU of the present time, and their answer.
  void tick(double yaw_rate_radps = 0.0) {
    graph_.clock.advance(0.05);
    sensor_msgs::Imu imu;
    imu.header.stamp = graph_.clock.now();
    imu.header.frame_id = "base_link";
    imu.angular_velocity.z = yaw_rate_radps;
    imu_pub_.publish(imu);
    graph_.publishOdometry();
  }
  void drive(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      tick();
      test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }, 0.02);
    }
  }
  sensor_msgs::Image picture(const MarkerMap& map = test::wallMap()) {
    const Pinhole camera = fromRos(graph_.info()).camera;
    const Eigen::Isometry3d map_from_camera =
        toIsometry(kMapFromOdom * graph_.pose) * test::CameraGraph::mount();
    return graph_.imageOf(test::viewOf(map, camera, map_from_camera, test::MarkerLight{}, random_), "mono8");
  }
  const MarkerObservationArray* show(const sensor_msgs::Image& image) {
    graph_.publish(image);
    return test::answerAt(observations_, image.header.stamp);
  }
  const PoseMessage* poseAt(ros::Time stamp) const {
    for (const PoseMessage& pose : poses_.messages) {
      if (pose.header.stamp == stamp) return &pose;
    }
    return nullptr;
  }
  /// A fix of the present time and a pose after it.
  void localize() {
    tick();
    const MarkerObservationArray* seen = show(picture());
    ASSERT_NE(seen, nullptr);
    ASSERT_TRUE(seen->accepted) << seen->reason;
    tick();
    ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
    ASSERT_TRUE(waitForTransform());
  }
  /// That of the present time, which comes on another connection than its pose.
  bool waitForTransform() {
    return test::waitUntil([this] {
      return !tf_.messages.empty() && tf_.messages.back().transforms.at(0).header.stamp == graph_.clock.now();
    });
  }
  /// A fit over markers of 20 px with 0.2 px of noise in the corners errs by some centimetres.
  void expectAtTruth(const geometry_msgs::Pose& pose) const {
    const Pose2 truth = kMapFromOdom * graph_.pose;
    EXPECT_LT(distance(*planar(pose), truth), 0.05);
    EXPECT_NEAR(angleBetween(planar(pose)->yaw_rad, truth.yaw_rad), 0.0, 0.03);
  }
  bool call(const std::string& name, bool on) {
    std_srvs::SetBool::Request request;
    std_srvs::SetBool::Response response;
    request.data = on ? 1 : 0;
    return callInBackground([&] { return ros::service::call(pnh_.resolveName(name), request, response); }) &&
           response.success != 0;
  }
  /// Calls a service of this process, whose callbacks are served here.
  static bool callInBackground(const std::function<bool()>& call) {
    std::atomic<bool> done{false};
    bool good = false;
    std::thread caller([&] {
      good = call();
      done = true;
    });
    test::waitUntil([&] { return done.load(); });
    caller.join();
    return good;
  }
  std::string status() {
    std::string text;
    for (const auto& message : diagnostics_.messages) {
      for (const auto& entry : message.status) text = entry.message;
    }
    return text;
  }

  const std::string name_ = "t" + std::to_string(count());
  test::CameraGraph graph_{name_};
  ros::NodeHandle pnh_{"~" + name_};
  ros::Publisher imu_pub_ = graph_.nh.advertise<sensor_msgs::Imu>("imu/data_raw", 10);
  test::Recorder<MarkerObservationArray> observations_{graph_.nh, "markers"};
  test::Recorder<PoseMessage> poses_{graph_.nh, "pose"};
  test::Recorder<tf2_msgs::TFMessage> tf_{graph_.nh, "/tf"};
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{graph_.nh, "/diagnostics"};
  Random random_{500005};
  std::unique_ptr<MarkerLocalizationNode> node_;
};

TEST_F(MarkerLocalizationNodeTest, TellsNothingBeforeTheFirstFixButThatItHasNone) {
  start();
  drive(25);
  EXPECT_TRUE(poses_.messages.empty());
  EXPECT_TRUE(tf_.messages.empty());
  const MarkerObservationArray* nothing =
      show(graph_.imageOf(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90))));
  ASSERT_NE(nothing, nullptr);
  EXPECT_TRUE(nothing->markers.empty());
  EXPECT_EQ(nothing->image_width, 320U);
  EXPECT_FALSE(nothing->accepted);
  EXPECT_EQ(nothing->reason, toText(MarkerFix::Status::kNoMarker));
  ASSERT_TRUE(test::waitUntil([this] {
    graph_.clock.advance(0.1);
    return status().find("no fix yet") != std::string::npos;
  }));
}

TEST_F(MarkerLocalizationNodeTest, GivesPoseAndTransformOfEachOdometryOnce) {
  start();
  localize();
  graph_.pose = {0.0, 0.0, 0.0};
  drive(20);
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  ASSERT_TRUE(waitForTransform());
  ASSERT_GE(poses_.messages.size(), 20U);
  expectAtTruth(poses_.messages.back().pose.pose);
  EXPECT_EQ(poses_.messages.back().header.frame_id, "map");
  EXPECT_GT(poses_.messages.back().pose.covariance[0], 0.0);
  ros::Time last;
  for (const tf2_msgs::TFMessage& message : tf_.messages) {
    const geometry_msgs::TransformStamped& transform = message.transforms.at(0);
    EXPECT_EQ(transform.header.frame_id, "map");
    EXPECT_EQ(transform.child_frame_id, "odom");
    EXPECT_GT(transform.header.stamp, last);
    EXPECT_NE(poseAt(transform.header.stamp), nullptr);
    last = transform.header.stamp;
  }
  const auto& transform = tf_.messages.back().transforms.at(0).transform;
  EXPECT_NEAR(transform.translation.x, kMapFromOdom.x_m, 0.05);
  EXPECT_NEAR(transform.translation.y, kMapFromOdom.y_m, 0.05);
  graph_.publishOdometry();  // the same stamp again
  const std::size_t count = tf_.messages.size();
  EXPECT_FALSE(test::waitUntil([&] { return tf_.messages.size() > count; }, 0.2));
}

TEST_F(MarkerLocalizationNodeTest, DescribesEachMarker) {
  start();
  MarkerMap map = test::wallMap();
  map.markers[17] = map.markers.at(1);  // one that nobody told the node of
  map.markers.erase(1);
  map.markers[17].id = 17;
  tick();
  const MarkerObservationArray* seen = show(picture(map));
  ASSERT_NE(seen, nullptr);
  EXPECT_TRUE(seen->accepted) << seen->reason;
  EXPECT_THAT(seen->unlisted_ids, testing::ElementsAre(17));
  ASSERT_GE(seen->markers.size(), 2U);
  const MarkerObservation& marker = seen->markers[0];
  EXPECT_EQ(marker.id, 0);
  EXPECT_DOUBLE_EQ(marker.size_m, 0.20);
  EXPECT_TRUE(marker.accepted);
  EXPECT_EQ(marker.reason, "used");
  EXPECT_TRUE(marker.has_pose);
  EXPECT_NEAR(marker.pose.pose.position.z, 2.4, 0.2);
  EXPECT_LT(marker.image_error_px, 1.0);
  EXPECT_LT(marker.object_error_m, 0.01);
  EXPECT_GT(marker.pose.covariance[14], marker.pose.covariance[0]) << "depth is what a camera knows least";
  EXPECT_GT(marker.corners_px[2], marker.corners_px[0]) << "upper right of upper left";
}

TEST_F(MarkerLocalizationNodeTest, TakesALateImageButNoneFromTheFuture) {
  start();
  localize();
  drive(10);
  sensor_msgs::Image image = picture();
  image.header.stamp -= ros::Duration(0.3);
  const MarkerObservationArray* late = show(image);
  ASSERT_NE(late, nullptr);
  EXPECT_TRUE(late->accepted) << late->reason;
  image.header.stamp = graph_.clock.now() + ros::Duration(5.0);
  const MarkerObservationArray* early = show(image);
  ASSERT_NE(early, nullptr);
  EXPECT_FALSE(early->accepted);
  EXPECT_EQ(early->reason, toText(FilterStatus::kFromFuture));
}

TEST_F(MarkerLocalizationNodeTest, TakesAPoseByTopicAndByService) {
  start();
  ros::Publisher set_pub = graph_.nh.advertise<PoseMessage>("set_pose", 1);
  ASSERT_TRUE(test::waitForSubscriber(set_pub));
  drive(5);
  PoseMessage given;
  given.header.frame_id = "map";
  given.pose.pose = toRos(Pose2{5.0, 6.0, 0.5});
  set_pub.publish(given);
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return !poses_.messages.empty();
  }));
  EXPECT_NEAR(poses_.messages.back().pose.pose.position.x, 5.0, 1e-6);
  EXPECT_NEAR(poses_.messages.back().pose.covariance[0], 0.04, 0.01) << "set_pose_sigma_m 0.2";
  SetPose service;
  service.request.pose = given;
  service.request.pose.pose.pose.position.x = 7.0;
  service.request.pose.pose.covariance[0] = service.request.pose.pose.covariance[7] = 0.01;
  service.request.pose.pose.covariance[35] = 0.01;
  const std::string name = graph_.nh.resolveName("set_pose");
  ASSERT_TRUE(callInBackground([&] { return ros::service::call(name, service); }));
  EXPECT_TRUE(service.response.success) << service.response.message;
  tick();
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  EXPECT_NEAR(poseAt(graph_.clock.now())->pose.pose.position.x, 7.0, 1e-3);
  service.request.pose.header.frame_id = "odom";
  ASSERT_TRUE(callInBackground([&] { return ros::service::call(name, service); }));
  EXPECT_FALSE(service.response.success);
  EXPECT_THAT(service.response.message, AllOf(HasSubstr("odom"), HasSubstr("map")));
}

TEST_F(MarkerLocalizationNodeTest, InputsCanBeSwitchedOff) {
  start();
  ASSERT_TRUE(call("use_markers", false));
  tick();
  const MarkerObservationArray* seen = show(picture());
  ASSERT_NE(seen, nullptr);
  EXPECT_FALSE(seen->accepted);
  EXPECT_FALSE(seen->markers.empty());
  EXPECT_EQ(seen->reason, toText(FilterStatus::kDisabled));
  EXPECT_TRUE(poses_.messages.empty());
  ASSERT_TRUE(call("use_markers", true));
  localize();
  ASSERT_TRUE(call("use_imu", false));
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return status().find("gyro silent") != std::string::npos;
  }));
}

TEST_F(MarkerLocalizationNodeTest, GoesOnWithTheImagesWhileOdometryIsSilent) {
  start();
  localize();
  const std::size_t transforms = tf_.messages.size();
  graph_.clock.advance(5.0);
  const MarkerObservationArray* seen = show(picture());
  ASSERT_NE(seen, nullptr);
  EXPECT_TRUE(seen->accepted) << seen->reason;
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
  EXPECT_EQ(tf_.messages.size(), transforms);
  tick();  // odometry is back
  EXPECT_TRUE(test::waitUntil([&] { return tf_.messages.size() > transforms; }));
}

TEST_F(MarkerLocalizationNodeTest, NumbersThatAreNoneAreNamedAndSurvived) {
  start();
  localize();
  tick(kNan);
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
  bool is_named = false;
  ASSERT_TRUE(test::waitUntil([&] {
    graph_.clock.advance(0.1);
    for (const auto& message : diagnostics_.messages) {
      for (const auto& value : message.status.at(0).values)
        is_named = is_named || value.value.find(toText(FilterStatus::kNotFinite)) != std::string::npos;
    }
    return is_named;
  }));
}

TEST_F(MarkerLocalizationNodeTest, AMarkerOfTheWrongSizeMovesNothing) {
  start();
  localize();
  MarkerMap map = test::wallMap();
  for (auto& [id, marker] : map.markers) marker.size_m *= 0.7;
  for (int i = 0; i < 5; ++i) {
    tick();
    const MarkerObservationArray* seen = show(picture(map));
    ASSERT_NE(seen, nullptr);
    EXPECT_FALSE(seen->accepted);
    EXPECT_THAT(seen->reason, testing::Not(testing::IsEmpty()));
  }
  drive(1);
  expectAtTruth(poses_.messages.back().pose.pose);
}

TEST_F(MarkerLocalizationNodeTest, AnImageWithoutCalibrationIsNamed) {
  start();
  sensor_msgs::CameraInfo zeros = graph_.info();
  zeros.K.fill(0.0);
  graph_.publish(zeros);
  tick();
  const MarkerObservationArray* seen = nullptr;
  ASSERT_TRUE(test::waitUntil([&] {  // the image may overtake the camera_info
    tick();
    seen = show(picture());
    return seen == nullptr || !seen->accepted;
  }));
  ASSERT_NE(seen, nullptr);
  EXPECT_THAT(seen->reason, HasSubstr("calibrate"));
}

TEST_F(MarkerLocalizationNodeTest, TimeJumpingBackStartsAnew) {
  start();
  localize();
  const std::size_t poses = poses_.messages.size();
  graph_.clock.set(graph_.clock.now() - ros::Duration(20.0));
  drive(5);
  EXPECT_EQ(poses_.messages.size(), poses);
  localize();
  expectAtTruth(poses_.messages.back().pose.pose);
}

TEST_F(MarkerLocalizationNodeTest, DrivesByCommandedSpeed) {
  pnh_.setParam("filter/twist_source", "command");
  start();
  ros::Publisher command_pub = graph_.nh.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10);
  ASSERT_TRUE(test::waitForSubscriber(command_pub));
  localize();
  for (int i = 0; i < 20; ++i) {
    graph_.clock.advance(0.05);
    geometry_msgs::TwistStamped command;
    command.header.stamp = graph_.clock.now();
    command.twist.linear.x = 0.2;
    command_pub.publish(command);
    graph_.pose = graph_.pose * arcMotion({i == 0 ? 0.0 : 0.2, 0.0}, 0.05);
  }
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
}

/// What the node says when it is started with a map of this text.
test::ProgramResult startWith(const std::string& map, const std::string& arguments = "") {
  const test::TempFolder folder;
  const std::string file = folder.write("map.yaml", map);
  return test::runProgram("marker_localization_node",
                          "__name:=marker_alone _marker_map:=" + file + " " + arguments);
}

TEST(MarkerLocalizationNode, ABadMapEndsItWithWhatIsWrong) {
  const std::string marker = "  - {id: 3, position: [4.0, 0.6, 0.5], rpy: [1.5707963, 0.0, -1.5707963]}\n";
  const test::ProgramResult twice = startWith("size_m: 0.2\nmarkers:\n" + marker + marker);
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.output, AllOf(HasSubstr("FATAL"), HasSubstr("3"), HasSubstr("map.yaml")));
  const test::ProgramResult unknown = startWith("dictionary: DICT_9X9_50\nsize_m: 0.2\nmarkers:\n" + marker);
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, AllOf(HasSubstr("FATAL"), HasSubstr("DICT_9X9_50"), HasSubstr("DICT_4X4_50")));
  const test::ProgramResult other =
      startWith("size_m: 0.2\nmarkers:\n" + marker, "_detector/dictionary:=DICT_6X6_50");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, AllOf(HasSubstr("DICT_6X6_50"), HasSubstr("DICT_4X4_50")));
}

TEST(MarkerLocalizationNode, NoMapAndUnknownParametersEndIt) {
  const test::ProgramResult none = test::runProgram("marker_localization_node", "__name:=marker_bare");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, AllOf(HasSubstr("FATAL"), HasSubstr("marker_map")));
  const test::ProgramResult missing =
      test::runProgram("marker_localization_node", "__name:=marker_alone _marker_map:=/nowhere/hall.yaml");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("/nowhere/hall.yaml"));
  const test::ProgramResult unknown = test::runProgram(
      "marker_localization_node", "__name:=marker_alone _marker_map:=" + kMap + " _use_gps:=true");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("use_gps"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "marker_localization_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
