#include <algorithm>
#include <numeric>

#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {
namespace {

/// Levenshtein's distance: insertions, deletions and replacements that lead from one text to the other.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, name.size() / 2) + 1;  // beyond half its letters it is no typo
  for (const std::string& candidate : known) {
    const std::size_t steps = editDistance(name, candidate);
    if (steps < least) {
      least = steps;
      nearest = candidate;
    }
  }
  return nearest;
}

std::unique_ptr<Suite> makeSuite(const std::string& name) {
  const auto found = suites().find(name);
  if (found != suites().end()) return found->second();
  std::vector<std::string> names;
  for (const auto& entry : suites()) names.push_back(entry.first);
  const std::string nearest = nearestName(name, names);
  throw ConfigError("there is no suite '" + name + "'" +
                    (nearest.empty() ? "; --list names them" : "; did you mean '" + nearest + "'?"));
}

}  // namespace frugal_nav::eval
