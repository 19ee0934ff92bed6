#pragma once

#include <optional>
#include <string>

#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::sim {

/// A loaded world as bytes, for the machine that wrote them.
std::string toBytes(const LoadedWorld& world);

/// The inverse of toBytes. Nothing when the bytes end early or go on behind the world.
std::optional<LoadedWorld> fromBytes(const std::string& bytes);

}  // namespace frugal_nav::sim
