#include "odometry_suite.hpp"

#include "square_drive.hpp"

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/odometry/wheel_calibration.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

struct OdometryOptions {
  double side_m = 4.0;
  double speed_mps = 0.3;
  int squares = 5;
  double radius_error_pct = 0.3;
  double separation_error_pct = 2.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("side_m", side_m, Field{"m", "side of the square", 0.5, 20.0});
    visit("speed_mps", speed_mps, Field{"m/s", "speed along a side", 0.05, 1.0});
    visit("squares", squares,
          Field{"", "squares each way, as in UMBmark, to calibrate and again to measure", 1, 50});
    visit("radius_error_pct", radius_error_pct,
          Field{"%", "each wheel's true radius is off by up to this from the URDF's", 0.0, 5.0});
    visit("separation_error_pct", separation_error_pct,
          Field{"%", "the true wheel separation is off by up to this from the URDF's", 0.0, 5.0});
  }
};

/// Calibration drives come from the range of seeds that is never evaluated on.
constexpr std::uint64_t kCalibrationSeeds = 500000;

/// Squares driven one way: the ends' errors of each odometry and the drift they are.
struct Campaign {
  std::vector<std::vector<Eigen::Vector2d>> errors;  ///< [odometry][square], truth less estimate [m]
  std::vector<std::vector<double>> drift_pct;        ///< [odometry][square]
};

double centroidOffset(const std::vector<Eigen::Vector2d>& errors) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& error : errors) sum += error;
  return sum.norm() / static_cast<double>(errors.size());
}

class OdometrySuite : public SuiteWithOptions<OdometryOptions> {
 public:
  std::string help() const override {
    return "wheel odometry on squares driven both ways: drift without slip, with slip, and after calibration";
  }
  int defaultTrials() const override { return 20; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
  }

  Rows runTrial(const Trial& trial) const override {
    const sim::DriveBodyParams body = drawBody(trial.seed);
    const WheelOdometryParams nominal;
    const WheelOdometryParams calibrated = calibrate(body, trial.seed + kCalibrationSeeds);
    sim::DriveBodyParams ideal;
    ideal.slip_scale = 0.0;

    Rows rows;
    std::map<bool, Campaign> measured;
    for (const bool clockwise : {true, false}) {
      const Campaign no_slip = drive(ideal, clockwise, 1, trial.seed, {nominal});
      Campaign& slip = measured[clockwise];
      slip = drive(body, clockwise, options_.squares, trial.seed, {nominal, calibrated});
      Json row;
      row["trial"] = trial.index;
      row["direction"] = clockwise ? "clockwise" : "counter_clockwise";
      row["drift_no_slip_pct"] = orNull(mean(no_slip.drift_pct[0]));
      row["drift_slip_pct"] = orNull(mean(slip.drift_pct[0]));
      row["drift_slip_calibrated_pct"] = orNull(mean(slip.drift_pct[1]));
      rows.push_back(row);
    }
    for (Json& row : rows) {
      row["umbmark_m"] = umbmark(measured, 0);
      row["umbmark_calibrated_m"] = umbmark(measured, 1);
      row["radius_ratio"] = body.right_radius_multiplier / body.left_radius_multiplier;
      row["radius_ratio_calibrated"] = calibrated.right_radius_multiplier / calibrated.left_radius_multiplier;
      row["separation_multiplier"] = body.separation_multiplier;
      row["separation_multiplier_calibrated"] = calibrated.separation_multiplier;
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    std::map<std::string, std::vector<double>> values;
    for (const Json& row : rows) {
      for (const auto& item : row.items()) {
        if (item.value().is_number()) values[item.key()].push_back(item.value().get<double>());
      }
    }
    Json summary;
    for (const char* key : {"drift_no_slip_pct", "drift_slip_pct", "drift_slip_calibrated_pct", "umbmark_m",
                            "umbmark_calibrated_m"})
      summary[key] = orNull(mean(values[key]));
    const auto& no_slip = values["drift_no_slip_pct"];
    summary["drift_no_slip_max_pct"] =
        no_slip.empty() ? Json() : Json(*std::max_element(no_slip.begin(), no_slip.end()));
    return summary;
  }

 private:
  sim::DriveBodyParams drawBody(std::uint64_t seed) const {
    Random random(seed, "body");
    const double radius = 0.01 * options_.radius_error_pct;
    const double separation = 0.01 * options_.separation_error_pct;
    sim::DriveBodyParams body;
    body.left_radius_multiplier = 1.0 + random.uniform(-radius, radius);
    body.right_radius_multiplier = 1.0 + random.uniform(-radius, radius);
    body.separation_multiplier = 1.0 + random.uniform(-separation, separation);
    return body;
  }

  Campaign drive(const sim::DriveBodyParams& body, bool clockwise, int squares, std::uint64_t seed,
                 const std::vector<WheelOdometryParams>& odometries) const {
    SquareParams square;
    square.side_m = options_.side_m;
    square.speed_mps = options_.speed_mps;
    square.clockwise = clockwise;
    Campaign campaign;
    campaign.errors.resize(odometries.size());
    campaign.drift_pct.resize(odometries.size());
    Random seeds(seed, clockwise ? "clockwise" : "counter_clockwise");
    for (int k = 0; k < squares; ++k) {
      const auto square_seed = static_cast<std::uint64_t>(seeds.integer(0, 1 << 30));
      const SquareDrive driven = driveSquare(robot_, square, body, square_seed, odometries);
      for (std::size_t i = 0; i < odometries.size(); ++i) {
        campaign.errors[i].push_back(driven.truth.position() - driven.estimates[i].position());
        campaign.drift_pct[i].push_back(100.0 * campaign.errors[i].back().norm() / driven.length_m);
      }
    }
    return campaign;
  }

  WheelOdometryParams calibrate(const sim::DriveBodyParams& body, std::uint64_t seed) const {
    WheelOdometryParams params;
    SquareErrors errors;
    errors.clockwise = drive(body, true, options_.squares, seed, {params}).errors[0];
    errors.counter_clockwise = drive(body, false, options_.squares, seed, {params}).errors[0];
    const WheelCalibration found = calibrateWheels(errors, options_.side_m, robot_.drive.separation_m);
    params.left_radius_multiplier = found.left_radius_multiplier;
    params.right_radius_multiplier = found.right_radius_multiplier;
    params.separation_multiplier = found.separation_multiplier;
    return params;
  }

  /// UMBmark's measure of the systematic error: the farther of the two ways' mean end errors.
  static double umbmark(const std::map<bool, Campaign>& measured, std::size_t odometry) {
    return std::max(centroidOffset(measured.at(true).errors[odometry]),
                    centroidOffset(measured.at(false).errors[odometry]));
  }

  RobotModel robot_;
};

}  // namespace

std::unique_ptr<Suite> makeOdometrySuite() { return std::make_unique<OdometrySuite>(); }

}  // namespace frugal_nav::eval
