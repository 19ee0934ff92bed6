#pragma once

#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/eval/runner.hpp>

namespace frugal_nav::eval {

/// What the evaluate tool is asked to do.
struct EvaluateCommand {
  enum class Action { kRun, kMerge, kList, kHelp };
  Action action = Action::kHelp;
  RunRequest request;                ///< for kRun; for kHelp its `suite` may name one
  std::string out = "results";       ///< folder of the files; for kMerge also a name that ends in .json
  bool trajectories = false;         ///< write trajectories under `out`
  std::vector<std::string> sources;  ///< for kMerge
};

/// Reads the arguments after the program's name. Throws ConfigError naming a wrong one, and for an unknown
/// suite or option the nearest known.
EvaluateCommand parseCommandLine(const std::vector<std::string>& arguments);

/// The general help, or that of one suite with its options.
std::string helpText(const std::string& suite);

/// Name and purpose of every suite, one a line.
std::string listText();

}  // namespace frugal_nav::eval
