#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// The parameters of a YAML file; nested maps become "group/key".
/// Throws ConfigError with file, line and column when it cannot be read.
ParamTree readParamFile(const std::string& path);

/// The parameters of a YAML text; `where` stands in the messages.
ParamTree parseParams(const std::string& yaml, const std::string& where);

/// A params struct from a YAML file of its keys; what the file does not name keeps its default.
/// Throws ConfigError on an unreadable file, an unknown key, a wrong type, or a value out of its range.
template <class Params>
Params loadParamFile(const std::string& path) {
  Params params;
  assign(readParamFile(path), path, params);
  return params;
}

}  // namespace frugal_nav
