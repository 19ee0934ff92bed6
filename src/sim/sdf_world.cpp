#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include <sdf/Console.hh>
#include <sdf/Root.hh>
#include <sdf/Scene.hh>
#include <sdf/World.hh>
#include <sdf/sdf_config.h>
#if SDF_MAJOR_VERSION >= 11
#include <sdf/ParserConfig.hh>
#else
#include <sdf/SDFImpl.hh>
#endif
#include <tinyxml2.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/scene_builder.hpp>
#include <frugal_nav/sim/sdf_model.hpp>
#include <frugal_nav/sim/sdf_warnings.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;

/// Why a file is no SDF, with file and line; empty when it is. libsdformat tells that only on the terminal.
std::string findXmlFault(const std::string& path) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(path.c_str()) != tinyxml2::XML_SUCCESS) {
    return path + ":" + std::to_string(document.ErrorLineNum()) + ": broken XML: " + document.ErrorStr();
  }
  const tinyxml2::XMLElement* root = document.RootElement();
  if (std::string(root->Name()) == "sdf" && root->Attribute("version") != nullptr) return {};
  return path + ":" + std::to_string(root->GetLineNum()) + ": begins with <" + root->Name() +
         "> instead of <sdf version='...'>";
}

/// Why an included model cannot be read; empty when it can. Notes the files that the parser will read.
std::string findModelFault(const fs::path& folder, SceneBuilder& builder) {
  bool has_sdf = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".sdf") has_sdf = true;
    if (extension == ".sdf" || extension == ".config") builder.noteFile(entry.path().string());
  }
  if (!has_sdf) return folder.string() + " holds no .sdf file";
  const fs::path model = folder / "model.sdf";
  return fs::exists(model) ? findXmlFault(model.string()) : "";
}

/// The folder or file of an included model; empty when it cannot be read, for then the parser goes on without
/// it.
std::string findInclude(const std::string& uri, const std::string& world_folder, SceneBuilder& builder) {
  const auto found = builder.resources().find(uri, world_folder);
  if (!found) {
    builder.warnMissing("included " + uri +
                        " is missing: looked in GAZEBO_MODEL_PATH, ROS_PACKAGE_PATH and beside the world");
    return {};
  }
  if (!fs::is_directory(*found)) {
    builder.noteFile(*found);
    return *found;
  }
  const std::string fault = findModelFault(*found, builder);
  if (fault.empty()) return *found;
  builder.warnMissing("included " + uri + " cannot be read: " + fault);
  return {};
}

std::string describe(const sdf::Error& error) {
#if SDF_MAJOR_VERSION >= 11
  std::string where = error.FilePath().value_or("");
  if (!where.empty() && error.LineNumber()) where += ":" + std::to_string(*error.LineNumber());
  if (!where.empty()) return where + ": " + error.Message();
#endif
  return error.Message();
}

sdf::Errors parse(const std::string& path, SceneBuilder& builder, sdf::Root& root) {
  static std::once_flag once;  // its errors come back as values
  std::call_once(once, [] { sdf::Console::Instance()->SetQuiet(true); });
  const std::string folder = fs::absolute(path).parent_path().string();
  const auto find = [&](const std::string& uri) { return findInclude(uri, folder, builder); };
#if SDF_MAJOR_VERSION >= 11
  sdf::ParserConfig config;
  config.SetFindCallback(find);
  return root.Load(path, config);
#else
  sdf::setFindCallback(find);
  const sdf::Errors errors = root.Load(path);
  sdf::setFindCallback({});
  return errors;
#endif
}

/// The poses of models in a saved world's `<state>`, by the models' names.
std::map<std::string, Eigen::Isometry3d> savedPoses(const sdf::ElementPtr& world) {
  std::map<std::string, Eigen::Isometry3d> poses;
  if (!world->HasElement("state")) return poses;
  const sdf::ElementPtr state = world->GetElement("state");
  if (!state->HasElement("model")) return poses;
  for (sdf::ElementPtr model = state->GetElement("model"); model; model = model->GetNextElement("model")) {
    if (!model->HasElement("pose")) continue;
    poses[model->Get<std::string>("name")] = toIsometry(model->Get<ignition::math::Pose3d>("pose"));
  }
  return poses;
}

void readScene(const sdf::Scene& source, Scene& scene) {
  const auto ambient = source.Ambient();
  const auto background = source.Background();
  scene.ambient = {ambient.R(), ambient.G(), ambient.B()};
  scene.background = {background.R(), background.G(), background.B()};
  if (source.Shadows()) return;
  for (Light& light : scene.lights) light.casts_shadows = false;
}

void addWorld(const sdf::World& world, SceneBuilder& builder) {
  builder.scene.name = world.Name();
  const auto saved = savedPoses(world.Element());
  for (std::uint64_t i = 0; i < world.ModelCount(); ++i) {
    const sdf::Model& model = *world.ModelByIndex(i);
    const auto pose = saved.find(model.Name());
    addModel(model,
             pose != saved.end() ? pose->second : resolvePose(model.SemanticPose(), model.Name(), builder),
             builder);
  }
  for (std::uint64_t i = 0; i < world.LightCount(); ++i) {
    addLight(*world.LightByIndex(i), Eigen::Isometry3d::Identity(), builder);
  }
  for (std::uint64_t i = 0; i < world.ActorCount(); ++i) addActor(*world.ActorByIndex(i), builder);
  if (world.Scene() != nullptr) readScene(*world.Scene(), builder.scene);
}

}  // namespace

LoadedWorld loadWorld(const std::string& path, const ResourcePath& resources) {
  if (!fs::is_regular_file(path)) {
    throw ConfigError("world " + path + " does not exist: give the path of an SDF world file");
  }
  const std::string fault = findXmlFault(path);
  if (!fault.empty()) throw ConfigError(fault);

  SceneBuilder builder(resources.withWorld(path));
  builder.noteFile(fs::absolute(path).lexically_normal().string());
  sdf::Root root;
  const sdf::Errors errors = parse(path, builder, root);
  if (root.WorldCount() == 0) {
    throw ConfigError(path + " has no <world> that can be read" +
                      (errors.empty() ? "" : ": " + describe(errors.front())));
  }
  for (const sdf::Error& error : errors) {
    const bool is_named_already = error.Message().find("Unable to find uri[") == 0;  // by findInclude
    if (!is_named_already) builder.warn(describe(error));
  }
  if (root.WorldCount() > 1) builder.warn(path + " has several worlds: only the first is simulated");
  const sdf::World& world = *root.WorldByIndex(0);
  addWorld(world, builder);
  warnOfUnsimulated(world.Element(), builder);
  return {std::move(builder.scene), builder.warnings(), builder.files(), builder.isComplete()};
}

}  // namespace frugal_nav::sim
