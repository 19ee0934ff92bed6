#include "barn_worlds.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::eval {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLengthsFile = "path_lengths.csv";

/// NUMBER of world_NUMBER.world; nothing for another name.
std::optional<int> numberOf(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::string prefix = "world_";
  if (path.extension() != ".world" || stem.rfind(prefix, 0) != 0) return std::nullopt;
  const std::string digits = stem.substr(prefix.size());
  const bool sound =
      !digits.empty() && digits.size() < 9 && digits.find_first_not_of("0123456789") == std::string::npos;
  return sound ? std::optional<int>(std::stoi(digits)) : std::nullopt;
}

std::map<int, double> readLengths(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError("barn: " + path.string() + " cannot be read");
  std::map<int, double> lengths;
  std::string line;
  std::getline(file, line);  // the header
  for (int number = 2; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
    std::istringstream fields(line);
    int world = 0;
    char comma = 0;
    double length_m = 0.0;
    if (!(fields >> world >> comma >> length_m) || comma != ',' || !(length_m > 0.0)) {
      throw ConfigError("barn: " + path.string() + ":" + std::to_string(number) +
                        ": expected a world's number, a comma and a length in metres");
    }
    lengths[world] = length_m;
  }
  return lengths;
}

fs::path findLengths(const fs::path& folder) {
  for (const fs::path& place : {folder, fs::absolute(folder).lexically_normal().parent_path(),
                                fs::absolute(folder / "..").lexically_normal()}) {
    if (fs::is_regular_file(place / kLengthsFile)) return place / kLengthsFile;
  }
  throw ConfigError("barn: no path_lengths.csv in " + folder.string() + " or beside it");
}

}  // namespace

std::vector<BarnWorld> listBarnWorlds(const std::string& folder) {
  if (!fs::is_directory(folder)) throw ConfigError("barn: " + folder + " is no folder of worlds");
  std::vector<BarnWorld> worlds;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (const auto number = numberOf(entry.path())) worlds.push_back({*number, entry.path().string(), 0.0});
  }
  if (worlds.empty()) throw ConfigError("barn: no file world_NUMBER.world in " + folder);
  std::sort(worlds.begin(), worlds.end(), [](const BarnWorld& a, const BarnWorld& b) {
    return a.number != b.number ? a.number < b.number : a.path < b.path;
  });
  const fs::path lengths_file = findLengths(folder);
  const std::map<int, double> lengths = readLengths(lengths_file);
  for (BarnWorld& world : worlds) {
    const auto found = lengths.find(world.number);
    if (found == lengths.end()) {
      throw ConfigError("barn: " + lengths_file.string() + " has no length for world " +
                        std::to_string(world.number));
    }
    world.path_length_m = found->second;
  }
  return worlds;
}

}  // namespace frugal_nav::eval
