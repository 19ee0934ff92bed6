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
/// running node; lists of numbers or texts are not part of that protocol and stay as they were at start.
class LiveParameterServer {
 public:
  /// `apply` takes the wanted values; it throws ConfigError when they are bad, and nothing changes.
  LiveParameterServer(const ros::NodeHandle& pnh, const std::vector<FieldDescription>& fields,
                      std::function<void(const ParamTree&)> apply);
  LiveParameterServer(const LiveParameterServer&) = delete;  // the service holds its address
  LiveParameterServer& operator=(const LiveParameterServer&) = delete;

 private:
  bool reconfigure(dynamic_reconfigure::Reconfigure::Request& request,
                   dynamic_reconfigure::Reconfigure::Response& response);
  dynamic_reconfigure::Config values() const;

  ros::NodeHandle pnh_;
  std::vector<FieldDescription> fields_;
  std::function<void(const ParamTree&)> apply_;
  ros::Publisher descriptions_;
  ros::Publisher updates_;
  ros::ServiceServer service_;
};

/// Live tuning of a params struct: `changed` gets the new struct once it has passed all checks.
template <class Params>
std::unique_ptr<LiveParameterServer> tuneLive(const ros::NodeHandle& pnh, Params params,
                                              std::function<void(const Params&)> changed) {
  const std::vector<FieldDescription> fields = describe(params);
  const std::string where = pnh.getNamespace();
  const auto apply = [params, changed, where](const ParamTree& tree) mutable {
    Params wanted = params;
    assign(tree, where, wanted);
    params = wanted;
    changed(params);
  };
  return std::make_unique<LiveParameterServer>(pnh, fields, apply);
}

}  // namespace frugal_nav
