#include "markers_suite.hpp"

#include "mrclam_drive.hpp"

#include <string>
#include <vector>

#include <frugal_nav/eval/statistics.hpp>

namespace frugal_nav::eval {
namespace {

struct MarkersOptions {
  std::string mrclam;
  MrclamParams robot;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("mrclam", mrclam,
          Field{"", "folder of a run of the UTIAS MRCLAM data set, unpacked; every robot in it"});
    visit("robot", robot);
  }
};

class MarkersSuite : public SuiteWithOptions<MarkersOptions> {
 public:
  std::string help() const override {
    return "the localization filter on real robots that see landmarks (--mrclam DIR): error, consistency, "
           "gate";
  }
  int defaultTrials() const override { return 1; }

  void prepare(const RunContext& /*context*/) override {
    if (options_.mrclam.empty()) {
      throw ConfigError("markers: --mrclam DIR is missing, a folder with Robot1_Odometry.dat and the like");
    }
    runs_ = readMrclam(options_.mrclam);
  }

  /// A recording is the same whatever the seed: one trial gives a row a robot, more repeat them.
  Rows runTrial(const Trial& trial) const override {
    Rows rows;
    for (const MrclamRun& run : runs_) {
      const MrclamScore score = scoreMrclam(run, options_.robot);
      Json row;
      row["trial"] = trial.index;
      row["robot"] = run.robot;
      row["position_rmse_m"] = score.position_rmse_m;
      row["yaw_rmse_deg"] = score.yaw_rmse_deg;
      row["anees"] = score.anees;
      row["gated_share"] = score.gated_share;
      rows.push_back(row);
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    Json summary;
    for (const char* key : {"position_rmse_m", "yaw_rmse_deg", "anees", "gated_share"}) {
      std::vector<double> values;
      for (const Json& row : rows) values.push_back(row.at(key).get<double>());
      summary[key] = orNull(mean(values));
    }
    return summary;
  }

 private:
  std::vector<MrclamRun> runs_;
};

}  // namespace

std::unique_ptr<Suite> makeMarkersSuite() { return std::make_unique<MarkersSuite>(); }

}  // namespace frugal_nav::eval
