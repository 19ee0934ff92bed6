#include <set>
#include <string>

#include <frugal_nav/sim/sdf_warnings.hpp>

namespace frugal_nav::sim {
namespace {

// Subtrees without influence on what the sensors measure here.
const std::set<std::string> kPassedOver{
    "gui",         "physics", "state",    "atmosphere", "spherical_coordinates",
    "wind",        "audio",   "inertial", "surface",    "magnetic_field",
    "enable_wind", "gravity", "material", "include"};
const std::set<std::string> kKnownShapes{"empty", "box", "cylinder", "sphere", "plane", "mesh"};
const std::set<std::string> kUnsimulated{
    "plugin",       "sensor",     "gripper",          "projector", "road", "population",
    "audio_source", "audio_sink", "particle_emitter", "battery",   "sky",  "fog"};

std::string nameOf(const sdf::ElementPtr& element) {
  return element->HasAttribute("name") ? element->Get<std::string>("name") : "";
}

/// What the element is called in a warning when it is not simulated; empty when it is.
std::string unsimulatedThing(const sdf::ElementPtr& element, const sdf::ElementPtr& parent) {
  const std::string& kind = element->GetName();
  if (kUnsimulated.count(kind) != 0) return kind + (nameOf(element).empty() ? "" : " " + nameOf(element));
  if (kind == "joint" && element->Get<std::string>("type") != "fixed") {
    return element->Get<std::string>("type") + " joint " + nameOf(element);
  }
  if (parent->GetName() == "geometry" && kKnownShapes.count(kind) == 0) return "shape " + kind;
  if (!parent->HasElementDescription(kind)) return "unknown element <" + kind + ">";
  return {};
}

void visit(const sdf::ElementPtr& parent, const std::string& owner, SceneBuilder& builder) {
  for (sdf::ElementPtr child = parent->GetFirstElement(); child; child = child->GetNextElement()) {
    const std::string& kind = child->GetName();
    if (kPassedOver.count(kind) != 0) continue;
    const std::string thing = unsimulatedThing(child, parent);
    if (!thing.empty()) {
      builder.warn(thing + " of " + owner + " is not simulated");
      continue;
    }
    std::string inner = owner;
    if (kind == "model") inner = parent->GetName() == "model" ? owner + "::" + nameOf(child) : nameOf(child);
    if (kind == "actor") inner = nameOf(child);
    visit(child, inner, builder);
  }
}

}  // namespace

void warnOfUnsimulated(const sdf::ElementPtr& world, SceneBuilder& builder) {
  visit(world, "the world", builder);
}

}  // namespace frugal_nav::sim
