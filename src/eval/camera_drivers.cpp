#include "camera_drivers.hpp"

#include "straight_drive.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/eval/visual_drive.hpp>

namespace frugal_nav::eval {
namespace {

class StraightDriver : public CameraDriver {
 public:
  StraightDriver(const CameraStackParams& params, const RobotModel& robot, const Pose2& odom_from_goal)
      : drive_(params.odometry, params.base, params.mission.xy_aim_m, robot, odom_from_goal) {}

  Twist2 addTicks(const sim::WheelTicks& ticks) override { return drive_.addTicks(ticks); }
  void addImage(const sim::CameraImage&) override {}
  Pose2 odometry() const override { return drive_.odometry(); }
  bool reached() const override { return drive_.reached(); }

 private:
  StraightDrive drive_;
};

class StackDriver : public CameraDriver {
 public:
  StackDriver(const CameraStackParams& params, const RobotModel& robot, const Pinhole& camera,
              Duration latency)
      : stack_(params, robot, camera, latency) {}

  Twist2 addTicks(const sim::WheelTicks& ticks) override {
    return stack_.addTicks(ticks.stamp, ticks.left, ticks.right).velocity;
  }
  void addImage(const sim::CameraImage& image) override { stack_.addImage(image.stamp, image.bgr); }
  Pose2 odometry() const override { return stack_.odometry().odom_from_base; }
  bool reached() const override { return phase() == MissionPhase::kReached; }
  std::string abortReason() const override {
    return phase() == MissionPhase::kAborted ? stack_.mission().status().reason : "";
  }
  std::string activity() const override {
    std::string text = "base: " + stack_.command().text + "; mission: " + stack_.mission().status().reason;
    if (stack_.last()) {
      text += "; planner: " + stack_.last()->plan.reason + "; gap: " + stack_.last()->depth.gap.reason +
              "; vo: " + frugal_nav::text(stack_.last()->visual.status.state);
    }
    return text;
  }
  std::string trouble() const override;
  cv::Mat lastView() const override;
  Path2 path() const override { return stack_.last() ? stack_.last()->plan.path : Path2{}; }
  std::vector<Eigen::Vector2d> remembered() const override;

 private:
  MissionPhase phase() const { return stack_.mission().status().phase; }

  CameraStack stack_;
};

std::string StackDriver::trouble() const {
  if (!stack_.last() || phase() == MissionPhase::kIdle) return "goal not found";
  if (stack_.mission().status().reason.find("lost") != std::string::npos) return "goal lost";
  switch (stack_.last()->plan.status) {
    case CameraPlan::Status::kNoPath:
      return "no way";
    case CameraPlan::Status::kHalted:
      return "halted";
    case CameraPlan::Status::kStopped:
      return "image unusable";
    default:
      return stack_.command().reason == BaseCommand::Reason::kObstacle ? "collision stop" : "";
  }
}

cv::Mat StackDriver::lastView() const {
  if (!stack_.last()) return {};
  const CameraResult& last = *stack_.last();
  cv::Mat view = last.bgr.clone();
  for (const Detection& detection : last.goal.detections)
    cv::rectangle(view, detection.box, cv::Scalar(0, 255, 0), 2);
  for (const VisualPoint& point : last.visual.points)
    cv::circle(view, {static_cast<int>(point.pixel.x()), static_cast<int>(point.pixel.y())}, 1,
               cv::Scalar(255, 255, 0), cv::FILLED);
  const NearestObstacle& obstacle = last.depth.obstacle;
  if (obstacle.found) {
    cv::rectangle(view, cv::Rect(obstacle.left_px, obstacle.top_px, obstacle.width_px, obstacle.height_px),
                  cv::Scalar(0, 0, 255), 2);
  }
  if (last.depth.gap.found) {
    for (const double column : {last.depth.gap.left_column_px, last.depth.gap.right_column_px}) {
      const int x = static_cast<int>(std::lround(column));
      cv::line(view, {x, 0}, {x, view.rows - 1}, cv::Scalar(255, 0, 255), 1);
    }
  }
  if (last.depth.depth_m.empty()) return view;
  cv::Mat inverse;
  cv::divide(1.0, last.depth.depth_m, inverse);
  cv::patchNaNs(inverse, 0.0);
  cv::Mat grey;
  inverse.convertTo(grey, CV_8U, 255.0 / 1.2);
  cv::resize(grey, grey, view.size(), 0.0, 0.0, cv::INTER_NEAREST);
  cv::Mat colour;
  cv::applyColorMap(grey, colour, cv::COLORMAP_TURBO);
  cv::Mat both;
  cv::vconcat(view, colour, both);
  return both;
}

std::vector<Eigen::Vector2d> StackDriver::remembered() const {
  std::vector<Eigen::Vector2d> points;
  const RollingGrid& grid = stack_.planner().memory().grid();
  for (int i = 0; i < grid.size() * grid.size(); ++i) {
    const Cell cell{grid.origin().x + i % grid.size(), grid.origin().y + i / grid.size()};
    if (grid.state(cell) == RollingGrid::State::kOccupied) points.push_back(grid.centerOf(cell));
  }
  return points;
}

}  // namespace

std::unique_ptr<CameraDriver> makeStraightDriver(const CameraStackParams& params, const RobotModel& robot,
                                                 double speed_mps, const Pose2& odom_from_goal) {
  CameraStackParams adapted = params;
  adapted.base.limits.max_v_mps = speed_mps;
  adapted.base.limits.creep_mps = std::min(adapted.base.limits.creep_mps, speed_mps);
  return std::make_unique<StraightDriver>(adapted, robot, odom_from_goal);
}

std::unique_ptr<CameraDriver> makeStackDriver(const CameraStackParams& params, const RobotModel& robot,
                                              double speed_mps, double rate_hz,
                                              const sim::Simulator& simulator) {
  CameraStackParams adapted = params;
  adapt(adapted, speed_mps, rate_hz);
  return std::make_unique<StackDriver>(adapted, robot, pinholeOf(simulator.camera()),
                                       fromSeconds(1.0 / rate_hz));
}

}  // namespace frugal_nav::eval
