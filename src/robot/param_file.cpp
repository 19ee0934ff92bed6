#include <yaml-cpp/yaml.h>

#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav {
namespace {

ParamValue scalar(const YAML::Node& node) {
  if (node.Tag() == "!") return node.Scalar();  // quoted: a text whatever it looks like
  bool truth = false;
  int integer = 0;
  double number = 0.0;
  if (YAML::convert<int>::decode(node, integer)) return integer;
  if (YAML::convert<double>::decode(node, number)) return number;
  if (YAML::convert<bool>::decode(node, truth)) return truth;
  return node.Scalar();
}

ParamValue sequence(const YAML::Node& node, const std::string& key, const std::string& where) {
  std::vector<double> numbers;
  std::vector<std::string> texts;
  for (const YAML::Node& item : node) {
    double number = 0.0;
    if (!item.IsScalar())
      throw ConfigError(where + ": \"" + key + "\" must be a list of numbers or of texts");
    if (item.Tag() != "!" && YAML::convert<double>::decode(item, number)) numbers.push_back(number);
    texts.push_back(item.Scalar());
  }
  if (numbers.size() == texts.size()) return numbers;
  return texts;
}

void flatten(const YAML::Node& node, const std::string& prefix, const std::string& where, ParamTree& tree) {
  for (const auto& entry : node) {
    const std::string key = prefix + entry.first.Scalar();
    if (entry.second.IsMap()) {
      flatten(entry.second, key + "/", where, tree);
    } else if (entry.second.IsSequence()) {
      tree[key] = sequence(entry.second, key, where);
    } else if (entry.second.IsScalar()) {
      tree[key] = scalar(entry.second);
    } else {
      throw ConfigError(where + ": \"" + key + "\" has no value");
    }
  }
}

ParamTree flattened(const YAML::Node& root, const std::string& where) {
  ParamTree tree;
  if (root.IsNull()) return tree;
  if (!root.IsMap()) throw ConfigError(where + ": expected \"key: value\" lines");
  flatten(root, "", where, tree);
  return tree;
}

std::string place(const YAML::Exception& error) {
  if (error.mark.is_null()) return "";
  return ":" + std::to_string(error.mark.line + 1) + ":" + std::to_string(error.mark.column + 1);
}

}  // namespace

ParamTree readParamFile(const std::string& path) {
  try {
    return flattened(YAML::LoadFile(path), path);
  } catch (const YAML::BadFile&) {
    throw ConfigError(path + ": cannot be read; is the path right?");
  } catch (const YAML::Exception& error) {
    throw ConfigError(path + place(error) + ": " + error.msg);
  }
}

ParamTree parseParams(const std::string& yaml, const std::string& where) {
  try {
    return flattened(YAML::Load(yaml), where);
  } catch (const YAML::Exception& error) {
    throw ConfigError(where + place(error) + ": " + error.msg);
  }
}

}  // namespace frugal_nav
