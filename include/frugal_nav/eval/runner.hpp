#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <frugal_nav/eval/result.hpp>
#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {

/// A part of a run's trials: trial k belongs to shard k mod count.
struct Shard {
  int index = 0;
  int count = 1;
};

/// What to run.
struct RunRequest {
  std::string suite;
  std::string version;
  RunContext context;
  int trials = 0;  ///< 0: the suite's default
  Shard shard;
  int threads = 0;  ///< 0: one per processor
  ParamTree options;
};

/// Told after each trial: how many are done, of how many.
using Progress = std::function<void(int done, int total)>;

/// Runs a suite on worker threads; the result does not depend on their number.
/// Throws ConfigError on an unknown suite or option; what a trial throws comes through.
Result runSuite(const RunRequest& request, const Progress& progress = {});

}  // namespace frugal_nav::eval
