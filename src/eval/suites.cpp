#include "lidar_suite.hpp"
#include "odometry_suite.hpp"

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

const std::map<std::string, SuiteFactory>& suites() {
  static const std::map<std::string, SuiteFactory> kSuites = {
      {"lidar", makeLidarSuite},
      {"odometry", makeOdometrySuite},
  };
  return kSuites;
}

}  // namespace frugal_nav::eval
