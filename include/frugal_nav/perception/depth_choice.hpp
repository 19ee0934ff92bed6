#pragma once

#include <memory>
#include <string>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/depth_network.hpp>

namespace frugal_nav {

/// Which depth network to run.
struct DepthChoice {
  std::string model = "depth_small";
  std::string model_file;
  std::string models_folder;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("model", model,
          atStart(
              Field{"",
                    "one of config/models (depth_small, midas_v21_small, fast_depth), or the path of such a "
                    "file; depth_small knows the simulator alone: on a robot take midas_v21_small"}));
    visit("model_file", model_file,
          atStart(Field{"", "the network's file in place of the one that the model names"}));
    visit("models_folder", models_folder,
          atStart(Field{"", "where files without a path lie; empty: the package's folder models"}));
  }
};

/// Path of the YAML file that a choice names, in the package at `share_dir`.
std::string configOf(const DepthChoice& choice, const std::string& share_dir);

/// The depth network of a choice. Throws ConfigError naming the file and what to do.
std::unique_ptr<DepthNetwork> makeDepthNetwork(const DepthChoice& choice, const std::string& share_dir);

}  // namespace frugal_nav
