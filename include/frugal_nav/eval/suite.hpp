#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/json.hpp>

namespace frugal_nav::eval {

/// What is the same for all trials of a run.
struct RunContext {
  std::string share_dir;       ///< the package's urdf/, config/, worlds/ lie here
  std::uint64_t seed = 1;      ///< of the run; trial k has seed + k
  std::string trajectory_dir;  ///< trajectory files go here; empty for none
  std::string picture_dir;     ///< pictures of failures go here; empty for none
};

/// One trial of a run. Its numbers follow from its seed alone, not from the trials beside it.
struct Trial {
  int index = 0;
  std::uint64_t seed = 0;
};

/// A measurement that can be repeated: seeded trials, a row or more each, and a summary of the rows.
class Suite {
 public:
  virtual ~Suite() = default;
  Suite() = default;
  Suite(const Suite&) = delete;
  Suite& operator=(const Suite&) = delete;

  /// One line that says what it measures.
  virtual std::string help() const = 0;
  virtual int defaultTrials() const = 0;
  /// Its options with their present values.
  virtual std::vector<FieldDescription> options() const = 0;
  /// Sets options; throws ConfigError naming an unknown one, a wrong type or a bad value.
  virtual void configure(const ParamTree& options) = 0;
  /// Called once before the trials: reads files, fits what the trials share. Throws ConfigError.
  virtual void prepare(const RunContext& context) = 0;
  /// Runs one trial; called from several threads at once.
  virtual Rows runTrial(const Trial& trial) const = 0;
  /// The summary of a whole run's rows; needs configure() but not prepare(). Null where a value is missing.
  virtual Json summarise(const Rows& rows) const = 0;
};

/// A suite whose options are a params struct.
template <class Options>
class SuiteWithOptions : public Suite {
 public:
  std::vector<FieldDescription> options() const override { return describe(options_); }
  void configure(const ParamTree& options) override { assign(options, "options", options_); }

 protected:
  Options options_;
};

/// The suites by name.
using SuiteFactory = std::function<std::unique_ptr<Suite>()>;
const std::map<std::string, SuiteFactory>& suites();

/// A suite by its name; throws ConfigError naming the nearest known one.
std::unique_ptr<Suite> makeSuite(const std::string& name);

/// The known name nearest to a mistyped one by edit distance; empty when none is near.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace frugal_nav::eval
