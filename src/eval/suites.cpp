#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

const std::map<std::string, SuiteFactory>& suites() {
  static const std::map<std::string, SuiteFactory> kSuites = {};
  return kSuites;
}

}  // namespace frugal_nav::eval
