#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <frugal_nav/eval/runner.hpp>

namespace frugal_nav::eval {
namespace {

Json toJson(const ParamValue& value) {
  return std::visit([](const auto& held) { return Json(held); }, value);
}

Json optionsOf(const Suite& suite, int trials) {
  Json options = Json::object();
  options["trials"] = trials;
  for (const FieldDescription& option : suite.options()) options[option.name] = toJson(option.value);
  return options;
}

std::vector<Trial> trialsOf(const RunRequest& request, int count) {
  std::vector<Trial> trials;
  for (int k = request.shard.index; k < count; k += request.shard.count) {
    trials.push_back({k, request.context.seed + static_cast<std::uint64_t>(k)});
  }
  return trials;
}

/// Runs the trials on `threads` threads; the rows come in the order of the trials.
Rows runTrials(const Suite& suite, const std::vector<Trial>& trials, int threads, const Progress& progress) {
  std::vector<Rows> rows(trials.size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;  // guards failure, done and the progress callback
  std::exception_ptr failure;
  int done = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < trials.size(); i = next++) {
      try {
        rows[i] = suite.runTrial(trials[i]);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!failure) failure = std::current_exception();
        next = trials.size();
        return;
      }
      const std::lock_guard<std::mutex> lock(mutex);
      ++done;
      if (progress) progress(done, static_cast<int>(trials.size()));
    }
  };
  std::vector<std::thread> workers;
  for (int i = 1; i < threads; ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);

  Rows all;
  for (const Rows& some : rows) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace

Result runSuite(const RunRequest& request, const Progress& progress) {
  const std::unique_ptr<Suite> suite = makeSuite(request.suite);
  suite->configure(request.options);
  suite->prepare(request.context);
  const int trials = request.trials > 0 ? request.trials : suite->defaultTrials();
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));

  Result result;
  result.suite = request.suite;
  result.version = request.version;
  result.seed = request.context.seed;
  result.options = optionsOf(*suite, trials);
  result.rows = runTrials(*suite, trialsOf(request, trials),
                          request.threads > 0 ? request.threads : processors, progress);
  result.summary = suite->summarise(result.rows);
  return result;
}

}  // namespace frugal_nav::eval
