#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Speaks dynamic_reconfigure's protocol for a list of fields, so that rqt_reconfigure and dynparam tune a
/// running node. Fields that count at the start only are not offered, and lists of numbers or texts are not
/// part of that protocol: both stay as they were.
class LiveParameterServer {
 public:
  /// Takes the wanted values and gives the fields as they are then; throws ConfigError when a value is bad,
  /// and nothing changes.
  using Apply = std::function<std::vector<FieldDescription>(const ParamTree&)>;

  LiveParameterServer(const ros::NodeHandle& pnh, const std::vector<FieldDescription>& fields, Apply apply);
  LiveParameterServer(const LiveParameterServer&) = delete;  // the service holds its address
  LiveParameterServer& operator=(const LiveParameterServer&) = delete;

 private:
  bool reconfigure(dynamic_reconfigure::Reconfigure::Request& request,
                   dynamic_reconfigure::Reconfigure::Response& response);
  dynamic_reconfigure::Config values() const;

  ros::NodeHandle pnh_;
  std::vector<FieldDescription> fields_;
  Apply apply_;
  ros::Publisher descriptions_;
  ros::Publisher updates_;
  ros::ServiceServer service_;
};

/// Live tuning of a params struct: `changed` gets the new struct once it has passed all checks; when it
/// throws ConfigError, the parameters stay as they were.
template <class Params>
std::unique_ptr<LiveParameterServer> tuneLive(const ros::NodeHandle& pnh, Params params,
                                              std::function<void(const Params&)> changed) {
  const std::vector<FieldDescription> fields = describe(params);
  const std::string where = pnh.getNamespace();
  const auto apply = [params, changed, where](const ParamTree& tree) mutable {
    Params wanted = params;
    assign(tree, where, wanted);
    changed(wanted);
    params = wanted;
    return describe(params);
  };
  return std::make_unique<LiveParameterServer>(pnh, fields, apply);
}

}  // namespace frugal_nav
