#include <algorithm>

#include <frugal_nav/perception/detector_choice.hpp>
#include <frugal_nav/perception/face_detectors.hpp>
#include <frugal_nav/perception/yolo_detector.hpp>

namespace frugal_nav {
namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool isPath(const std::string& name) {
  return name.find('/') != std::string::npos || endsWith(name, ".yaml");
}

template <class Params>
Params assigned(const ParamTree& tree, const std::string& where) {
  Params params;
  assign(tree, where, params);
  return params;
}

/// The detectors of faces know one class only.
void checkFacesWanted(const DetectorChoice& choice) {
  const auto& wanted = choice.wanted;
  if (wanted.empty() || std::find(wanted.begin(), wanted.end(), "face") != wanted.end()) return;
  throw ConfigError("wanted: model \"" + choice.model + "\" finds nothing but \"face\"");
}

}  // namespace

std::string configOf(const DetectorChoice& choice, const std::string& share_dir) {
  return isPath(choice.model) ? choice.model : share_dir + "/config/models/" + choice.model + ".yaml";
}

std::unique_ptr<Detector> makeDetector(ParamTree tree, const DetectorChoice& choice,
                                       const std::string& share_dir) {
  const std::string where = configOf(choice, share_dir);
  const std::string folder = choice.models_folder.empty() ? share_dir + "/models" : choice.models_folder;
  const auto kind = tree.find("kind");
  const auto is_kind = [&](const char* name) {
    return kind != tree.end() && kind->second == ParamValue(std::string(name));
  };
  const bool is_yunet = is_kind("yunet");
  const bool is_cascade = is_kind("cascade");
  if (is_yunet || is_cascade) {
    checkFacesWanted(choice);
  } else if (!choice.wanted.empty()) {
    tree["wanted"] = choice.wanted;
  }
  if (!choice.model_file.empty()) tree[is_cascade ? "cascade_file" : "model"] = choice.model_file;
  if (endsWith(choice.model_file, ".cfg"))
    tree["weights"] = choice.model_file.substr(0, choice.model_file.size() - 3) + "weights";
  if (is_cascade) return std::make_unique<CascadeFaceDetector>(assigned<CascadeFaceParams>(tree, where));
  if (is_yunet) return std::make_unique<YunetDetector>(assigned<YunetParams>(tree, where), folder);
  return std::make_unique<YoloDetector>(assigned<YoloParams>(tree, where), folder);
}

}  // namespace frugal_nav
