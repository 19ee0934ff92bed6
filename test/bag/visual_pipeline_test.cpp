// Reads a drive toward a person, with something in the way, back from a bag and runs the whole pipeline over
// it in this process, from image to velocity, with the parameters of hybrid.launch. Figures are of the whole
// run.

#include "camera_course_bag.hpp"

#include <functional>
#include <optional>
#include <string>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/eval/camera_stack.hpp>

namespace frugal_nav {
namespace {

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;

class CameraPipelineBag : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    layout_ = test::courseLayout();
    bag_ = test::recordCourse(layout_);
  }

  /// Runs the whole pipeline over the bag. `show` gives what the camera shows at a time since the start [s],
  /// empty for nothing; `watch` is called after each reading of the encoders.
  void runPipeline(const std::function<cv::Mat(double, const cv::Mat&)>& show,
                   const std::function<void(double, const eval::CameraStack&, const BaseCommand&)>& watch) {
    eval::CameraStackParams params = eval::loadCameraStack(kSource);
    eval::adapt(params, test::kCourseSpeed_mps, test::kCourseRate_hz);
    eval::CameraStack stack(params, robot_, bag_.calibration.camera, fromSeconds(0.5 / test::kCourseRate_hz));
    const Stamp start = bag_.ticks.front().stamp;
    std::size_t next = 0;
    for (const auto& [stamp, left, right] : bag_.ticks) {
      for (; next < bag_.images.size() && bag_.images[next].stamp <= stamp; ++next) {
        const auto& [shown_at, image] = bag_.images[next];
        const cv::Mat shown = show(toSeconds(shown_at - start), image.bgr);
        if (!shown.empty()) stack.addImage(shown_at, shown);
      }
      const BaseCommand command = stack.addTicks(stamp, left, right);
      watch(toSeconds(stamp - start), stack, command);
    }
  }

  static eval::CameraLayout layout_;
  static test::CourseBag bag_;
  const RobotModel robot_ = loadRobot(kSource + "/urdf/frugal_bot.urdf");
};

eval::CameraLayout CameraPipelineBag::layout_;
test::CourseBag CameraPipelineBag::bag_;

TEST_F(CameraPipelineBag, LeadsToThePerson) {
  std::optional<double> goal_since_s;
  std::optional<Stamp> last;
  std::optional<Eigen::Vector2d> p_person;
  int results = 0;
  int clear = 0;
  int tracked = 0;
  int moving = 0;
  runPipeline([](double, const cv::Mat& image) { return image; },
              [&](double time_s, const eval::CameraStack& stack, const BaseCommand& command) {
                if (!goal_since_s && stack.mission().active()) goal_since_s = time_s;
                if (!goal_since_s || stack.last()->stamp == last) return;
                last = stack.last()->stamp;
                const CameraPlan& plan = stack.last()->plan;
                ++results;
                clear +=
                    !plan.path.empty() && test::clearance(plan.path, layout_) > robot_.halfWidth_m() ? 1 : 0;
                tracked += stack.last()->visual.status.state == VisualState::kTracking ? 1 : 0;
                moving += command.velocity.isZero() ? 0 : 1;
                p_person = stack.mission().person();
              });
  ASSERT_TRUE(goal_since_s.has_value());
  EXPECT_LT(*goal_since_s, 2.0);  // three sightings make a goal
  EXPECT_GT(test::share(clear, results), 0.8);
  EXPECT_GT(test::share(moving, results), 0.8);
  EXPECT_GT(test::share(tracked, results), 0.6);  // the map starts once the robot has come some way
  // A head's size differs by 5 % between people, its box's edges by a pixel or two: 15 % of 5.5 m at most.
  ASSERT_TRUE(p_person.has_value());
  EXPECT_LT((*p_person - layout_.p_person).norm(), 0.15 * layout_.p_person.norm());
}

TEST_F(CameraPipelineBag, StandsWhileTheCameraShowsNothingAndGoesOn) {
  constexpr double kFrom_s = 1.8;
  constexpr double kTo_s = 3.5;
  const cv::Size size = bag_.images.front().image.bgr.size();
  const cv::Mat black(size, CV_8UC3, cv::Scalar::all(0));
  const cv::Mat white(size, CV_8UC3, cv::Scalar::all(255));
  // The first useless image takes effect after the pipeline's period and latency; a silent camera with the
  // path's time-out.
  const double period_s = 1.0 / test::kCourseRate_hz;
  const double timeout_s = eval::loadCameraStack(kSource).base.timeouts.path_s;
  const std::tuple<const char*, cv::Mat, double> cases[] = {{"black", black, 2.0 * period_s},
                                                            {"saturated", white, 2.0 * period_s},
                                                            {"silent", cv::Mat(), timeout_s + period_s}};
  for (const auto& [name, shown, limit_s] : cases) {
    SCOPED_TRACE(name);
    bool moved_before = false;
    bool moved_after = false;
    double stands_since_s = 0.0;
    std::string fault;
    runPipeline([&](double time_s,
                    const cv::Mat& image) { return time_s < kFrom_s || time_s > kTo_s ? image : shown; },
                [&](double time_s, const eval::CameraStack& stack, const BaseCommand& command) {
                  const bool stands = command.velocity.isZero();
                  if (time_s < kFrom_s) moved_before = moved_before || !stands;
                  if (time_s > kTo_s) moved_after = moved_after || !stands;
                  if (time_s > kFrom_s && time_s <= kTo_s && !stands) stands_since_s = time_s;
                  const bool ends = time_s <= kTo_s && time_s > kTo_s - period_s;
                  if (ends && !shown.empty()) fault = stack.last()->depth.fault;
                });
    EXPECT_TRUE(moved_before);
    if (!shown.empty()) {
      EXPECT_THAT(fault, testing::HasSubstr(name));
    }
    EXPECT_LT(stands_since_s, kFrom_s + limit_s);
    EXPECT_TRUE(moved_after);
  }
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
