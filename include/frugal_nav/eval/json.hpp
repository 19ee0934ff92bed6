#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

namespace frugal_nav::eval {

/// A JSON value whose objects keep the order in which their keys were set.
using Json = nlohmann::ordered_json;
/// What one trial measured, a JSON object each; the first key is always "trial".
using Rows = std::vector<Json>;

/// A number, or null for one that does not exist.
inline Json orNull(std::optional<double> value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

}  // namespace frugal_nav::eval
