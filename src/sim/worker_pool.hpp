#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace frugal_nav::sim {

/// Threads that wait for work. Tasks of one run must not depend on each other or on which thread does them.
class WorkerPool {
 public:
  /// A pool of `threads` in all: the caller's is one of them.
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Calls task(0) ... task(count - 1), in any order on any thread; returns when all are done.
  void run(int count, const std::function<void(int)>& task);

 private:
  void work();
  void takeTasks();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(int)>* task_ = nullptr;
  std::atomic<int> next_{0};
  int count_ = 0;
  int busy_ = 0;
  unsigned round_ = 0;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace frugal_nav::sim
