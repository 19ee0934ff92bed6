#include "barn_suite.hpp"
#include "depth_suite.hpp"
#include "detector_suite.hpp"
#include "lidar_suite.hpp"
#include "localization_suite.hpp"
#include "markers_suite.hpp"
#include "odometry_suite.hpp"
#include "pipeline_suite.hpp"
#include "success_suite.hpp"

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

const std::map<std::string, SuiteFactory>& suites() {
  static const std::map<std::string, SuiteFactory> kSuites = {
      {"barn", makeBarnSuite},
      {"depth", makeDepthSuite},
      {"detector", makeDetectorSuite},
      {"lidar", makeLidarSuite},
      {"localization", makeLocalizationSuite},
      {"markers", makeMarkersSuite},
      {"odometry", makeOdometrySuite},
      {"pipeline", makePipelineSuite},
      {"success", makeSuccessSuite},
  };
  return kSuites;
}

}  // namespace frugal_nav::eval
