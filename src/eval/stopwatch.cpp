#include <chrono>

#include <frugal_nav/eval/stopwatch.hpp>

namespace frugal_nav::eval {

double wallTime_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

}  // namespace frugal_nav::eval
