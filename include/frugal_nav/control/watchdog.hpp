#pragma once

#include <map>
#include <optional>
#include <string>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// Watches the stamps of named inputs: each must be no older than its time-out.
class Watchdog {
 public:
  /// Adds an input, or changes its time-out.
  void watch(const std::string& input, double timeout_s);
  /// Notes an input's stamp. False when it is older than the one before: time has jumped back.
  bool feed(const std::string& input, Stamp stamp);
  /// Forgets all stamps.
  void reset();

  /// What is wrong with an input ("no scan yet", "scan is 0.61 s old, more than 0.50 s"); nullopt when it is
  /// fresh. An input that is not watched is a fault.
  std::optional<std::string> fault(const std::string& input, Stamp now) const;
  /// The stamp last fed; nullopt when none was.
  std::optional<Stamp> last(const std::string& input) const;

 private:
  struct Watched {
    Duration timeout{};
    std::optional<Stamp> last;
  };
  std::map<std::string, Watched> inputs_;
};

}  // namespace frugal_nav
