#include <algorithm>
#include <limits>

#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/console.h>

#include <frugal_nav/ros/live_parameters.hpp>

namespace frugal_nav {
namespace {

using dynamic_reconfigure::Config;

/// Puts one value into the part of a Config that holds its type; false for lists, which the protocol lacks.
bool put(const std::string& name, const ParamValue& value, Config& config) {
  const auto add = [&name](auto& rows, const auto& v) {
    rows.emplace_back();
    rows.back().name = name;
    rows.back().value = v;
    return true;
  };
  if (const bool* truth = std::get_if<bool>(&value))
    return add(config.bools, static_cast<std::uint8_t>(*truth));
  if (const int* integer = std::get_if<int>(&value)) return add(config.ints, *integer);
  if (const double* number = std::get_if<double>(&value)) return add(config.doubles, *number);
  if (const auto* text = std::get_if<std::string>(&value)) return add(config.strs, *text);
  return false;
}

/// The bound of a field as its own type, since a spin box needs a finite one.
ParamValue bound(const FieldDescription& row, bool upper) {
  const double limit = upper ? row.field.max : row.field.min;
  if (std::holds_alternative<int>(row.value)) {
    constexpr double kMost = std::numeric_limits<int>::max();
    return static_cast<int>(std::clamp(limit, -kMost, kMost));
  }
  if (std::holds_alternative<double>(row.value)) return std::clamp(limit, -1e9, 1e9);
  if (std::holds_alternative<bool>(row.value)) return upper;
  return std::string();
}

const char* typeOf(const ParamValue& value) {
  static constexpr const char* kNames[] = {"bool", "int", "double", "str", "", ""};
  return kNames[value.index()];
}

dynamic_reconfigure::ConfigDescription describeFields(const std::vector<FieldDescription>& fields) {
  dynamic_reconfigure::ConfigDescription description;
  description.groups.resize(1);
  description.groups[0].name = "Default";
  for (const FieldDescription& row : fields) {
    if (!put(row.name, row.value, description.dflt)) continue;
    put(row.name, bound(row, false), description.min);
    put(row.name, bound(row, true), description.max);
    dynamic_reconfigure::ParamDescription parameter;
    parameter.name = row.name;
    parameter.type = typeOf(row.value);
    parameter.description =
        (*row.field.unit ? "[" + std::string(row.field.unit) + "] " : "") + row.field.reason;
    description.groups[0].parameters.push_back(parameter);
  }
  return description;
}

std::vector<FieldDescription> liveOnes(std::vector<FieldDescription> fields) {
  fields.erase(std::remove_if(fields.begin(), fields.end(),
                              [](const FieldDescription& row) { return !row.field.live; }),
               fields.end());
  return fields;
}

ParamTree toTree(const Config& config) {
  ParamTree tree;
  for (const auto& row : config.bools) tree[row.name] = static_cast<bool>(row.value);
  for (const auto& row : config.ints) tree[row.name] = static_cast<int>(row.value);
  for (const auto& row : config.doubles) tree[row.name] = static_cast<double>(row.value);
  for (const auto& row : config.strs) tree[row.name] = row.value;
  return tree;
}

}  // namespace

LiveParameterServer::LiveParameterServer(const ros::NodeHandle& pnh,
                                         const std::vector<FieldDescription>& fields, Apply apply)
    : pnh_(pnh), fields_(liveOnes(fields)), apply_(std::move(apply)) {
  descriptions_ = pnh_.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true);
  updates_ = pnh_.advertise<Config>("parameter_updates", 1, true);
  service_ = pnh_.advertiseService("set_parameters", &LiveParameterServer::reconfigure, this);
  descriptions_.publish(describeFields(fields_));
  updates_.publish(values());
}

bool LiveParameterServer::reconfigure(dynamic_reconfigure::Reconfigure::Request& request,
                                      dynamic_reconfigure::Reconfigure::Response& response) {
  const ParamTree wanted = toTree(request.config);
  try {
    for (const auto& [name, value] : wanted) {
      const bool offered =
          std::any_of(fields_.begin(), fields_.end(),
                      [&name = name](const FieldDescription& row) { return row.name == name; });
      if (!offered)
        throw ConfigError("\"" + name + "\" cannot be changed while the node runs: start it anew");
    }
    fields_ = liveOnes(apply_(wanted));
  } catch (const ConfigError& error) {
    ROS_ERROR("%s; nothing changed", error.what());
  }
  response.config = values();
  updates_.publish(response.config);
  return true;
}

Config LiveParameterServer::values() const {
  Config config;
  for (const FieldDescription& row : fields_) put(row.name, row.value, config);
  config.groups.resize(1);
  config.groups[0].name = "Default";
  config.groups[0].state = 1;
  return config;
}

}  // namespace frugal_nav
