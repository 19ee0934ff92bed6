#include <frugal_nav/odometry/visual_rays.hpp>

namespace frugal_nav {

SharedRays sharedBetween(const RayMap& before, const RayMap& now) {
  SharedRays shared;
  for (const auto& [id, ray] : now) {
    const auto earlier = before.find(id);
    if (earlier == before.end()) continue;
    shared.ids.push_back(id);
    shared.before.push_back(earlier->second);
    shared.now.push_back(ray);
  }
  return shared;
}

}  // namespace frugal_nav
