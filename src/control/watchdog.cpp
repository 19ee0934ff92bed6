#include <cstdio>

#include <frugal_nav/control/watchdog.hpp>

namespace frugal_nav {

void Watchdog::watch(const std::string& input, double timeout_s) {
  inputs_[input].timeout = fromSeconds(timeout_s);
}

bool Watchdog::feed(const std::string& input, Stamp stamp) {
  std::optional<Stamp>& last = inputs_[input].last;
  const bool forward = !last || stamp >= *last;
  last = stamp;
  return forward;
}

void Watchdog::reset() {
  for (auto& [name, input] : inputs_) input.last.reset();
}

std::optional<std::string> Watchdog::fault(const std::string& input, Stamp now) const {
  const auto found = inputs_.find(input);
  if (found == inputs_.end() || !found->second.last) return "no " + input + " yet";
  const Duration age = now - *found->second.last;
  if (age <= found->second.timeout) return std::nullopt;
  char text[160];
  std::snprintf(text, sizeof text, "%s is %.2f s old, more than %.2f s", input.c_str(), toSeconds(age),
                toSeconds(found->second.timeout));
  return text;
}

std::optional<Stamp> Watchdog::last(const std::string& input) const {
  const auto found = inputs_.find(input);
  return found == inputs_.end() ? std::nullopt : found->second.last;
}

}  // namespace frugal_nav
