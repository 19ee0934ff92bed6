#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::test {

/// What a call that must throw ConfigError says.
template <class Call>
std::string messageOf(Call call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace frugal_nav::test
