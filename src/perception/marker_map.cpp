#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <set>
#include <sstream>

#include <yaml-cpp/yaml.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>
#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav {
namespace {

constexpr double kMinSize_m = 0.01;
constexpr double kMaxSize_m = 2.0;
constexpr double kMaxCoordinate_m = 1000.0;

/// Reads a map's YAML and collects what is wrong with it.
class MapReader {
 public:
  explicit MapReader(std::string where) : where_(std::move(where)) {}

  MarkerMap read(const YAML::Node& root) {
    if (!root.IsMap()) throw ConfigError(where_ + ": expected the keys frame, dictionary, size_m, markers");
    refuseUnknown(root, "", {"frame", "dictionary", "size_m", "whitelist", "markers"});
    readHeader(root);
    const YAML::Node markers = root["markers"];
    if (!markers || !markers.IsSequence() || markers.size() == 0) {
      fault("markers", "must be a list of markers with at least one");
    } else {
      for (std::size_t i = 0; i < markers.size(); ++i) readMarker(markers[i], i);
    }
    readWhitelist(root["whitelist"]);
    if (!faults_.empty()) throw ConfigError(faults_);
    return map_;
  }

 private:
  void fault(const std::string& key, const std::string& text) {
    faults_ += (faults_.empty() ? "" : "\n") + where_ + ": " + key + " " + text;
  }

  void refuseUnknown(const YAML::Node& node, const std::string& prefix,
                     std::initializer_list<const char*> known) {
    for (const auto& entry : node) {
      const std::string key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      std::string list;
      for (const char* name : known) list += std::string(list.empty() ? "" : ", ") + name;
      fault(prefix + key, "is unknown; known are " + list);
    }
  }

  void readHeader(const YAML::Node& root) {
    if (root["frame"]) map_.frame = text(root["frame"], "frame");
    if (root["dictionary"]) map_.dictionary = text(root["dictionary"], "dictionary");
    try {
      id_count_ = MarkerDictionary(map_.dictionary).count();
    } catch (const ConfigError& error) {
      fault("dictionary", std::string("is wrong: ") + error.what());
    }
    if (root["size_m"]) default_size_m_ = size(root["size_m"], "size_m");
  }

  std::string text(const YAML::Node& node, const std::string& key) {
    if (node.IsScalar() && !node.Scalar().empty()) return node.Scalar();
    fault(key, "must be a name");
    return "";
  }

  std::optional<double> size(const YAML::Node& node, const std::string& key) {
    double value = 0.0;
    if (!YAML::convert<double>::decode(node, value)) {
      fault(key, "must be a number of metres");
    } else if (!(value >= kMinSize_m && value <= kMaxSize_m)) {
      std::ostringstream out;
      out << "= " << value << " is no side of a marker in metres (" << kMinSize_m << " to " << kMaxSize_m
          << "); is it in mm or cm?";
      fault(key, out.str());
    } else {
      return value;
    }
    return std::nullopt;
  }

  std::optional<int> id(const YAML::Node& node, const std::string& key) {
    int value = 0;
    if (!node || !YAML::convert<int>::decode(node, value)) {
      fault(key, "must be a whole number");
    } else if (id_count_ > 0 && (value < 0 || value >= id_count_)) {  // 0: the dictionary is the fault
      fault(key, "= " + std::to_string(value) + " is not in " + map_.dictionary + ", which has 0 to " +
                     std::to_string(id_count_ - 1));
    } else {
      return value;
    }
    return std::nullopt;
  }

  std::optional<Eigen::Vector3d> triple(const YAML::Node& node, const std::string& key, double limit,
                                        const std::string& unit_hint) {
    Eigen::Vector3d values;
    if (!node || !node.IsSequence() || node.size() != 3) {
      fault(key, "must be a list of three numbers");
      return std::nullopt;
    }
    for (int i = 0; i < 3; ++i) {
      double value = 0.0;
      if (!YAML::convert<double>::decode(node[i], value) || !std::isfinite(value)) {
        fault(key, "must be a list of three numbers");
        return std::nullopt;
      }
      if (std::abs(value) > limit) {
        std::ostringstream out;
        out << "holds " << value << ": " << unit_hint;
        fault(key, out.str());
        return std::nullopt;
      }
      values[i] = value;
    }
    return values;
  }

  void readMarker(const YAML::Node& node, std::size_t i) {
    std::string key = "markers[" + std::to_string(i) + "]";
    if (!node.IsMap()) {
      fault(key, "must be {id, position, rpy}, with size_m if it has one of its own");
      return;
    }
    refuseUnknown(node, key + "/", {"id", "size_m", "position", "rpy"});
    const std::optional<int> marker_id = id(node["id"], key + "/id");
    if (marker_id) key += " (id " + std::to_string(*marker_id) + ")";
    std::optional<double> size_m = default_size_m_;
    if (node["size_m"]) {
      size_m = size(node["size_m"], key + "/size_m");
    } else if (!default_size_m_) {
      fault(key + "/size_m", "is missing, and there is no usable size_m for all");
    }
    const auto position = triple(node["position"], key + "/position", kMaxCoordinate_m,
                                 "too far away in metres; is it in mm or cm?");
    const auto rpy = triple(node["rpy"], key + "/rpy", 2.0 * M_PI + 0.01,
                            "more than a full turn in radians; is it in degrees?");
    if (!marker_id) return;
    if (!seen_.insert(*marker_id).second) fault(key + "/id", "is there twice: one id, one place");
    if (!size_m || !position || !rpy) return;
    MappedMarker marker;
    marker.id = *marker_id;
    marker.size_m = *size_m;
    marker.map_from_marker.translation() = *position;
    marker.map_from_marker.linear() = (Eigen::AngleAxisd(rpy->z(), Eigen::Vector3d::UnitZ()) *
                                       Eigen::AngleAxisd(rpy->y(), Eigen::Vector3d::UnitY()) *
                                       Eigen::AngleAxisd(rpy->x(), Eigen::Vector3d::UnitX()))
                                          .toRotationMatrix();
    map_.markers[marker.id] = marker;
  }

  void readWhitelist(const YAML::Node& node) {
    if (!node) {
      for (const auto& entry : map_.markers) map_.whitelist.push_back(entry.first);
      return;
    }
    if (!node.IsSequence() || node.size() == 0) {
      fault("whitelist", "must be a list of ids; leave it out to use all markers");
      return;
    }
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::optional<int> listed = id(node[i], "whitelist[" + std::to_string(i) + "]");
      if (listed) map_.whitelist.push_back(*listed);
    }
  }

  std::string where_;
  std::string faults_;
  MarkerMap map_;
  std::optional<double> default_size_m_;
  std::set<int> seen_;
  int id_count_ = 0;
};

}  // namespace

std::array<Eigen::Vector3d, 4> markerCorners(double size_m) {
  const double h = 0.5 * size_m;
  return {Eigen::Vector3d(-h, h, 0.0), Eigen::Vector3d(h, h, 0.0), Eigen::Vector3d(h, -h, 0.0),
          Eigen::Vector3d(-h, -h, 0.0)};
}

std::array<Eigen::Vector3d, 4> MappedMarker::corners() const { return markerCorners(size_m); }

MarkerMap parseMarkerMap(const std::string& yaml, const std::string& where) {
  try {
    return MapReader(where).read(YAML::Load(yaml));
  } catch (const YAML::Exception& error) {
    const std::string place = error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    throw ConfigError(where + place + ": " + error.msg);
  }
}

MarkerMap loadMarkerMap(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw ConfigError(path + ": cannot be read; is the path right?");
  return parseMarkerMap(text.str(), path);
}

}  // namespace frugal_nav
