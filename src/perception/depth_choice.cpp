#include <frugal_nav/perception/depth_choice.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav {
namespace {

bool isPath(const std::string& name) {
  const std::string end = ".yaml";
  return name.find('/') != std::string::npos ||
         (name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0);
}

}  // namespace

std::string configOf(const DepthChoice& choice, const std::string& share_dir) {
  return isPath(choice.model) ? choice.model : share_dir + "/config/models/" + choice.model + ".yaml";
}

std::unique_ptr<DepthNetwork> makeDepthNetwork(const DepthChoice& choice, const std::string& share_dir) {
  auto params = loadParamFile<DepthNetworkParams>(configOf(choice, share_dir));
  if (!choice.model_file.empty()) params.model = choice.model_file;
  const std::string folder = choice.models_folder.empty() ? share_dir + "/models" : choice.models_folder;
  return std::make_unique<OnnxDepthNetwork>(params, choice.model_file.empty() ? folder : "");
}

}  // namespace frugal_nav
