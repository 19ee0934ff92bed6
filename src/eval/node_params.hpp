#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav::eval {

/// The part of a node's parameter files that a params struct names, the keys below `prefix` ("range/"): the
/// rest is the node class's (frames, waits). Of a key in several files the last one holds, as for a launch
/// file that loads them in that order. Throws ConfigError as loadParamFile().
template <class Params>
Params loadPart(const std::vector<std::string>& paths, const std::string& prefix = "") {
  Params params;
  const std::vector<FieldDescription> known = describe(params);
  for (const std::string& path : paths) {
    const ParamTree file = readParamFile(path);
    ParamTree part;
    for (const FieldDescription& field : known) {
      const auto found = file.find(prefix + field.name);
      if (found != file.end()) part[field.name] = found->second;
    }
    assign(part, path, params);
  }
  return params;
}

}  // namespace frugal_nav::eval
