#pragma once

#include <memory>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/detector.hpp>

namespace frugal_nav {

/// Which detector to run.
struct DetectorChoice {
  std::string model = "heads";
  std::string model_file;
  std::string models_folder;
  std::vector<std::string> wanted;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("model", model,
          atStart(Field{
              "",
              "one of config/models (heads, yolov7, yolox_nano, yunet, haar_faces, ...), or the path of "
              "such a file"}));
    visit("model_file", model_file,
          atStart(Field{
              "",
              "the network's file in place of the one that the model names; of a .cfg, the .weights lie "
              "beside it"}));
    visit("models_folder", models_folder,
          atStart(Field{"", "where files without a path lie; empty: the package's folder models"}));
    visit("wanted", wanted, atStart(Field{"", "labels to look for; empty: those that the model names"}));
  }
};

/// Path of the YAML file that a choice names, in the package at `share_dir`.
std::string configOf(const DetectorChoice& choice, const std::string& share_dir);

/// The detector that a model's file (read into `tree`) describes: its key `kind` tells yunet and cascade from
/// the YOLO layouts. Throws ConfigError naming the file and what to do.
std::unique_ptr<Detector> makeDetector(ParamTree tree, const DetectorChoice& choice,
                                       const std::string& share_dir);

}  // namespace frugal_nav
