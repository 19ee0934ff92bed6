#include <frugal_nav/ros/parameters.hpp>

namespace frugal_nav {
namespace {

using XmlRpc::XmlRpcValue;

double number(const XmlRpcValue& value) {
  return value.getType() == XmlRpcValue::TypeInt ? static_cast<double>(static_cast<int>(value))
                                                 : static_cast<double>(value);
}

bool isNumber(const XmlRpcValue& value) {
  return value.getType() == XmlRpcValue::TypeInt || value.getType() == XmlRpcValue::TypeDouble;
}

ParamValue list(const XmlRpcValue& value, const std::string& key, const std::string& where) {
  std::vector<double> numbers;
  std::vector<std::string> texts;
  for (int i = 0; i < value.size(); ++i) {
    if (isNumber(value[i])) {
      numbers.push_back(number(value[i]));
    } else if (value[i].getType() == XmlRpcValue::TypeString) {
      texts.push_back(static_cast<std::string>(value[i]));
    } else {
      throw ConfigError(where + ": \"" + key + "\" must be a list of numbers or of texts");
    }
  }
  if (!numbers.empty() && !texts.empty()) {
    throw ConfigError(where + ": \"" + key + "\" mixes numbers and texts in one list");
  }
  if (!texts.empty()) return texts;
  return numbers;
}

void flatten(const XmlRpcValue& value, const std::string& key, const std::string& where, ParamTree& tree) {
  switch (value.getType()) {
    case XmlRpcValue::TypeStruct:
      for (const auto& [name, member] : value)
        flatten(member, key.empty() ? name : key + "/" + name, where, tree);
      return;
    case XmlRpcValue::TypeBoolean:
      tree[key] = static_cast<bool>(value);
      return;
    case XmlRpcValue::TypeInt:
      tree[key] = static_cast<int>(value);
      return;
    case XmlRpcValue::TypeDouble:
      tree[key] = static_cast<double>(value);
      return;
    case XmlRpcValue::TypeString:
      tree[key] = static_cast<std::string>(value);
      return;
    case XmlRpcValue::TypeArray:
      tree[key] = list(value, key, where);
      return;
    default:
      throw ConfigError(where + ": \"" + key + "\" has a type that no parameter here has");
  }
}

}  // namespace

ParamTree readParameterServer(const ros::NodeHandle& nh) {
  ParamTree tree;
  XmlRpcValue root;
  if (!nh.getParam(nh.getNamespace(), root)) return tree;
  if (root.getType() != XmlRpcValue::TypeStruct) {
    throw ConfigError(nh.getNamespace() + ": expected parameters in this namespace, found a single value");
  }
  flatten(root, "", nh.getNamespace(), tree);
  return tree;
}

RobotModel loadRobotDescription(const ros::NodeHandle& nh, const std::string& base_frame) {
  std::string key;
  std::string urdf;
  if (!nh.searchParam("robot_description", key) || !nh.getParam(key, urdf)) {
    throw ConfigError(
        "parameter \"robot_description\" is not set: load the robot's URDF first, "
        "e.g. <param name=\"robot_description\" textfile=\"$(find frugal_nav)/urdf/frugal_bot.urdf\"/>");
  }
  return parseRobot(urdf, key, base_frame);
}

}  // namespace frugal_nav
