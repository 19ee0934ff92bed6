// Looks through a map of markers before a robot relies on it.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_map_check.hpp>

namespace frugal_nav {
namespace {

constexpr const char* kUsage =
    "usage: check_marker_map FILE [--max-height M] [--min-height M]\n"
    "  Prints what is wrong with a map of markers and what looks like a mistake: ids that are there twice or "
    "not\n"
    "  in the dictionary, missing sizes, lengths in mm or cm, angles in degrees, markers that overlap, hang "
    "out of\n"
    "  reach or face up or down.\n"
    "  --max-height  highest centre of a marker that the camera sees (default 2.5)\n"
    "  --min-height  lowest lower edge (default 0)\n"
    "  Exit code: 0 nothing found, 1 something found, 2 wrong arguments.\n";

bool readNumber(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0' && std::isfinite(value);
}

bool parse(const std::vector<std::string>& arguments, std::string& path, MarkerMapLimits& limits) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--max-height" && has_value) {
      if (!readNumber(arguments[++i], limits.max_height_m)) return false;
    } else if (arguments[i] == "--min-height" && has_value) {
      if (!readNumber(arguments[++i], limits.min_height_m)) return false;
    } else if (path.empty() && arguments[i].rfind("--", 0) != 0) {
      path = arguments[i];
    } else {
      return false;
    }
  }
  return !path.empty();
}

int check(const std::string& path, const MarkerMapLimits& limits) {
  const MarkerMap map = loadMarkerMap(path);
  std::printf("%s: %zu markers of %s in frame %s\n", path.c_str(), map.markers.size(), map.dictionary.c_str(),
              map.frame.c_str());
  for (const auto& [id, marker] : map.markers) {
    const Eigen::Vector3d p = marker.map_from_marker.translation();
    const Eigen::Vector3d out = marker.map_from_marker.linear().col(2);
    std::printf("  id %d: %.3f m, at (%.2f, %.2f, %.2f), faces (%.2f, %.2f, %.2f)\n", id, marker.size_m,
                p.x(), p.y(), p.z(), out.x(), out.y(), out.z());
  }
  const std::vector<std::string> found = suspicionsAbout(map, limits);
  for (const std::string& line : found) std::printf("SUSPICIOUS %s\n", line.c_str());
  if (found.empty()) std::printf("ok\n");
  return found.empty() ? 0 : 1;
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments[0] == "--help") {
    std::fputs(frugal_nav::kUsage, stdout);
    return 0;
  }
  std::string path;
  frugal_nav::MarkerMapLimits limits;
  if (!frugal_nav::parse(arguments, path, limits)) {
    std::fputs(frugal_nav::kUsage, stderr);
    return 2;
  }
  try {
    return frugal_nav::check(path, limits);
  } catch (const frugal_nav::ConfigError& error) {
    std::printf("FAULT %s\n", error.what());
    return 1;
  }
}
