// Makes sheets of markers to print.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_map.hpp>
#include <frugal_nav/perception/marker_sheet.hpp>

namespace frugal_nav {
namespace {

constexpr const char* kHelp =
    "usage: print_markers --ids LIST --size M [--dictionary NAME] [--paper NAME] [--out FOLDER]\n"
    "       print_markers --map FILE [--paper NAME] [--out FOLDER]\n"
    "  Writes a page in SVG for each marker, in true size: marker_000.svg and so on.\n"
    "  --ids         such as 0-9 or 3,7,12\n"
    "  --size        side of the black square in metres\n"
    "  --dictionary  OpenCV's name (default DICT_4X4_50)\n"
    "  --map         all markers of a map, in its sizes\n"
    "  --paper       a4 (default), a3, a2, letter\n"
    "  --format      svg (default), or png: the marker alone with a white border one cell wide, for a "
    "simulator\n"
    "  --out         folder, made if need be (default: here)\n";

struct Options {
  std::map<int, double> sizes_m;  // by id
  std::string dictionary = "DICT_4X4_50";
  PaperSize paper;
  bool as_texture = false;
  std::filesystem::path out = ".";
};

int parseId(const std::string& text) {
  if (text.empty() || text.size() > 6 || text.find_first_not_of("0123456789") != std::string::npos)
    throw ConfigError("--ids takes a list such as 0-9 or 3,7,12; \"" + text + "\" is no id");
  return std::stoi(text);
}

std::vector<int> parseIds(const std::string& list) {
  std::vector<int> ids;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string part = list.substr(begin, end - begin);
    const std::size_t dash = part.find('-');
    const int first = parseId(part.substr(0, dash));
    const int last = dash == std::string::npos ? first : parseId(part.substr(dash + 1));
    if (last < first) throw ConfigError("--ids: " + part + " counts backwards");
    for (int id = first; id <= last; ++id) ids.push_back(id);
    begin = end + 1;
  }
  return ids;
}

PaperSize parsePaper(const std::string& name) {
  static const std::map<std::string, PaperSize> kPapers = {
      {"a4", {210.0, 297.0}}, {"a3", {297.0, 420.0}}, {"a2", {420.0, 594.0}}, {"letter", {215.9, 279.4}}};
  const auto found = kPapers.find(name);
  if (found == kPapers.end()) throw ConfigError("--paper takes a4, a3, a2 or letter, not \"" + name + "\"");
  return found->second;
}

double parseSize(const std::string& text) {
  char* end = nullptr;
  const double size_m = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !(size_m > 0.0))
    throw ConfigError("--size takes metres, not \"" + text + "\"");
  return size_m;
}

Options parse(const std::vector<std::string>& arguments) {
  std::map<std::string, std::string> given;
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    static const std::string kKnown = " --ids --size --dictionary --map --paper --format --out ";
    if (kKnown.find(" " + arguments[i] + " ") == std::string::npos)
      throw ConfigError("unknown option " + arguments[i] + "; see --help");
    if (i + 1 == arguments.size()) throw ConfigError(arguments[i] + " takes a value");
    given[arguments[i]] = arguments[i + 1];
  }
  Options options;
  if (given.count("--paper") > 0) options.paper = parsePaper(given["--paper"]);
  if (given.count("--out") > 0) options.out = given["--out"];
  if (given.count("--format") > 0) {
    options.as_texture = given["--format"] == "png";
    if (!options.as_texture && given["--format"] != "svg") throw ConfigError("--format takes svg or png");
  }
  if (given.count("--map") > 0) {
    if (given.count("--ids") + given.count("--size") + given.count("--dictionary") > 0)
      throw ConfigError("--map brings its own ids, sizes and dictionary");
    const MarkerMap map = loadMarkerMap(given["--map"]);
    options.dictionary = map.dictionary;
    for (const auto& [id, marker] : map.markers) options.sizes_m[id] = marker.size_m;
    return options;
  }
  if (given.count("--ids") == 0 || given.count("--size") == 0)
    throw ConfigError("either --map, or --ids and --size are needed; see --help");
  if (given.count("--dictionary") > 0) options.dictionary = given["--dictionary"];
  for (const int id : parseIds(given["--ids"])) options.sizes_m[id] = parseSize(given["--size"]);
  return options;
}

/// Whether the file could be written.
bool write(const Options& options, const MarkerDictionary& dictionary, int id, double size_m,
           const std::filesystem::path& path) {
  constexpr int kTextureCell_px = 32;  // with 4x4 markers 256 px in all: halved without a rest down to cells
  if (options.as_texture)
    return cv::imwrite(path.string(), markerTexture(dictionary, id, kTextureCell_px),
                       {cv::IMWRITE_PNG_BILEVEL, 1});
  const std::string sheet = markerSheet(dictionary, id, size_m, options.paper);
  std::ofstream file(path);
  file << sheet;
  return static_cast<bool>(file.flush());
}

void run(const Options& options) {
  const MarkerDictionary dictionary(options.dictionary);
  std::filesystem::create_directories(options.out);
  for (const auto& [id, size_m] : options.sizes_m) {
    char name[32];
    std::snprintf(name, sizeof name, "marker_%03d.%s", id, options.as_texture ? "png" : "svg");
    const std::filesystem::path path = options.out / name;
    if (!write(options, dictionary, id, size_m, path)) throw ConfigError("cannot write " + path.string());
    std::cout << path.string() << "\n";
  }
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0] == "--help") {
    std::cout << frugal_nav::kHelp;
    return arguments.empty() ? 2 : 0;
  }
  try {
    frugal_nav::run(frugal_nav::parse(arguments));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "print_markers: " << error.what() << "\n";
    return 1;
  }
}
