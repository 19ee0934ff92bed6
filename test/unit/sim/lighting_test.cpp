#include "box_scene.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/sim/lighting.hpp>

namespace frugal_nav::sim {
namespace {

/// A wide floor at z = 0 under a vertical sun.
BoxScene sunnyFloor() {
  BoxScene world;
  world.addBox({20.0F, 20.0F, 1.0F}, at(0.0, 0.0, -0.5), world.addMaterial({0.8F, 0.8F, 0.8F}));
  world.addSun({0.0, 0.0, -1.0});
  return world;
}

TEST(Lighting, GivesADeskTheIlluminanceAskedFor) {
  BoxScene world = sunnyFloor();
  world.addBox({6.0F, 0.2F, 2.5F}, at(0.0, 4.0, 1.25), 0);
  world.addBox({6.0F, 0.2F, 2.5F}, at(0.0, -4.0, 1.25), 0);
  Light lamp;
  lamp.position_m = {0.0, 0.0, 12.0};  // high: the plane is lit evenly
  world.scene.lights.push_back(lamp);
  world.scene.ambient.setConstant(0.2F);
  const RayTracer tracer(world.scene);
  for (const char* setting : {"daylight", "dim", "tube"}) {
    LightingParams params;
    params.setting = setting;
    const Lighting lighting(params, tracer, 11);
    EXPECT_EQ(lighting.illuminance_lx(), Lighting(params, tracer, 11).illuminance_lx());
    EXPECT_NE(lighting.illuminance_lx(), Lighting(params, tracer, 12).illuminance_lx());
    const double low = params.setting == "daylight" ? 500.0 : params.setting == "dim" ? 10.0 : 1000.0;
    const double high = params.setting == "daylight" ? 1000.0 : params.setting == "dim" ? 50.0 : 2000.0;
    EXPECT_GE(lighting.illuminance_lx(), low) << setting;
    EXPECT_LE(lighting.illuminance_lx(), high) << setting;
    // The median over the grid is exact; at one point the lamp's falling off adds a few percent.
    const double here = lighting.measure(tracer, {1.5, 1.0, 0.8});
    EXPECT_NEAR(here, lighting.illuminance_lx(), 0.15 * lighting.illuminance_lx()) << setting;
  }
}

TEST(Lighting, WorldWithoutLightsGetsOne) {
  BoxScene world;
  world.addBox({20.0F, 20.0F, 1.0F}, at(0.0, 0.0, -0.5), world.addMaterial({1, 1, 1}));
  const RayTracer tracer(world.scene);
  LightingParams params;
  params.illuminance_lx = 300.0;
  const Lighting lighting(params, tracer, 1);
  EXPECT_NEAR(lighting.measure(tracer, {0.0, 0.0, 0.8}), 300.0, 1.0);
}

TEST(Lighting, RefusesAnUnknownSetting) {
  const Scene scene;
  const RayTracer tracer(scene);
  LightingParams params;
  params.setting = "moonlight";
  EXPECT_THROW(Lighting(params, tracer, 1), ConfigError);
}

}  // namespace
}  // namespace frugal_nav::sim
