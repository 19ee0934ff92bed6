#include <cmath>

#include <gtest/gtest.h>
#include <support/temp_folder.hpp>
#include <unit/sim/world_files.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::sim {
namespace {

using frugal_nav::test::TempFolder;
using test::collisionText;
using test::mentions;
using test::meshText;
using test::modelText;
using test::visualText;
using test::worldText;

LoadedWorld load(const TempFolder& folder, const std::string& elements) {
  return loadWorld(folder.write("test.world", worldText(elements)), {});
}

const Material& materialOf(const Scene& scene, std::size_t model) {
  const Mesh& mesh = scene.meshes[static_cast<std::size_t>(scene.models.at(model).visuals.at(0).mesh)];
  return scene.materials[static_cast<std::size_t>(mesh.triangle_material.at(0))];
}

std::string errorOf(const std::string& path) {
  try {
    loadWorld(path, {});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SdfWorld, ReadsEverySimpleShape) {
  const TempFolder folder;
  std::string models;
  const std::vector<std::string> shapes{
      "<box><size>1 2 3</size></box>", "<cylinder><radius>0.5</radius><length>2</length></cylinder>",
      "<sphere><radius>0.25</radius></sphere>", "<plane><normal>0 1 0</normal><size>4 6</size></plane>"};
  for (const std::string& shape : shapes) {
    models += modelText("m" + std::to_string(models.size()), visualText(shape) + collisionText(shape));
  }
  const LoadedWorld world = load(folder, models);
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  ASSERT_EQ(world.scene.models.size(), 4U);
  const auto collision = [&](std::size_t i) { return world.scene.models[i].collisions.at(0); };
  EXPECT_EQ(collision(0).kind, Collision::Kind::kBox);
  EXPECT_TRUE(collision(0).size_m.isApprox(Eigen::Vector3d(1.0, 2.0, 3.0)));
  EXPECT_EQ(collision(1).kind, Collision::Kind::kCylinder);
  EXPECT_TRUE(collision(1).size_m.isApprox(Eigen::Vector3d(0.5, 0.5, 2.0)));
  EXPECT_EQ(collision(2).kind, Collision::Kind::kSphere);
  EXPECT_DOUBLE_EQ(collision(2).size_m.x(), 0.25);
  EXPECT_EQ(collision(3).kind, Collision::Kind::kPlane);
  EXPECT_TRUE(collision(3).size_m.isApprox(Eigen::Vector3d::UnitY()));
  const std::vector<std::size_t> corners{24, 132, 561, 4};  // 33 pairs and 2 caps of 33; 17 rows of 33
  for (std::size_t i = 0; i < 4; ++i) {
    const int mesh = world.scene.models[i].visuals.at(0).mesh;
    EXPECT_EQ(world.scene.meshes[static_cast<std::size_t>(mesh)].vertices.size(), corners[i]);
  }
}

TEST(SdfWorld, SharesEqualMeshes) {
  const TempFolder folder;
  const std::string box = "<box><size>1 1 1</size></box>";
  const std::string red = "<material><diffuse>1 0 0 1</diffuse></material>";
  const LoadedWorld world =
      load(folder, modelText("a", visualText(box, red)) + modelText("b", visualText(box, red)) +
                       modelText("c", visualText(box)));
  EXPECT_EQ(world.scene.models[0].visuals[0].mesh, world.scene.models[1].visuals[0].mesh);
  EXPECT_NE(world.scene.models[0].visuals[0].mesh, world.scene.models[2].visuals[0].mesh);
}

TEST(SdfWorld, ResolvesNestedPosesAndFrames) {
  const TempFolder folder;
  const std::string text =
      "<?xml version='1.0'?><sdf version='1.8'><world name='w'><model name='outer'><static>1</static>"
      "<pose>1 0 0 0 0 1.5707963267948966</pose>"
      "<frame name='shelf'><pose>0 0 1 0 0 0</pose></frame>"
      "<link name='base'><pose relative_to='shelf'>0 0 0.5 0 0 0</pose>"
      "<visual name='v'><pose relative_to='__model__'>2 0 0 0 0 0</pose>"
      "<geometry><box><size>1 1 1</size></box></geometry></visual>"
      "<collision name='c'><pose>1 0 0 0 0 0</pose><geometry><box><size>1 1 "
      "1</size></box></geometry></collision>"
      "</link>"
      "<model name='inner'><pose>0 3 0 0 0 0</pose><link name='l'><pose>0 0 2 0 0 0</pose>"
      "<visual name='v'><geometry><box><size>1 1 1</size></box></geometry></visual></link></model>"
      "</model></world></sdf>";
  const LoadedWorld world = loadWorld(folder.write("test.world", text), {});
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  ASSERT_EQ(world.scene.models.size(), 1U);
  const Model& model = world.scene.models[0];
  const Eigen::Vector3d ahead = model.world_from_model * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(ahead.isApprox(Eigen::Vector3d(1.0, 1.0, 0.0), 1e-9));
  ASSERT_EQ(model.visuals.size(), 2U);
  EXPECT_TRUE(
      model.visuals[0].model_from_visual.translation().isApprox(Eigen::Vector3d(2.0, 0.0, 0.0), 1e-9));
  EXPECT_TRUE(
      model.collisions[0].model_from_collision.translation().isApprox(Eigen::Vector3d(1.0, 0.0, 1.5), 1e-9));
  EXPECT_TRUE(
      model.visuals[1].model_from_visual.translation().isApprox(Eigen::Vector3d(0.0, 3.0, 2.0), 1e-9));
}

TEST(SdfWorld, WarnsOfAnUnknownFrameAndKeepsTheRest) {
  const TempFolder folder;
  const std::string text =
      "<?xml version='1.0'?><sdf version='1.8'><world name='w'><model name='lost'><static>1</static>"
      "<pose relative_to='nowhere'>1 2 3 0 0 0</pose><link name='l'><visual name='v'><geometry><sphere>"
      "<radius>1</radius></sphere></geometry></visual></link></model></world></sdf>";
  const LoadedWorld world = loadWorld(folder.write("test.world", text), {});
  EXPECT_TRUE(mentions(world.warnings, {"lost", "nowhere"}));
  ASSERT_EQ(world.scene.models.size(), 1U);
}

TEST(SdfWorld, PutsModelsWhereASavedStateHasThem) {
  const TempFolder folder;
  const LoadedWorld world =
      load(folder, modelText("box", visualText("<box><size>1 1 1</size></box>"), "9 9 0 0 0 0") +
                       "<state world_name='test'><model name='box'><pose frame=''>1 2 0 0 0 0</pose>"
                       "<link name='link'><pose frame=''>1 2 0 0 0 0</pose></link></model></state>");
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  EXPECT_TRUE(
      world.scene.models.at(0).world_from_model.translation().isApprox(Eigen::Vector3d(1.0, 2.0, 0.0)));
}

TEST(SdfWorld, ReadsColours) {
  const TempFolder folder;
  const std::string box = "<box><size>1 1 1</size></box>";
  const auto with = [&](const std::string& name, const std::string& material) {
    return modelText(name, visualText(box, "<material>" + material + "</material>"));
  };
  const LoadedWorld world =
      load(folder, with("a", "<ambient>0.1 0.1 0.1 1</ambient><diffuse>0.2 0.3 0.4 1</diffuse>") +
                       with("b", "<ambient>0.5 0.6 0.7 1</ambient>") +
                       with("c",
                            "<script><uri>file://media/materials/scripts/gazebo.material</uri>"
                            "<name>Gazebo/SkyBlue</name></script>") +
                       with("d", "<emissive>1 0.5 0 1</emissive>") +
                       with("e", "<script><uri>x</uri><name>My/Plaid</name></script>"));
  EXPECT_TRUE(materialOf(world.scene, 0).albedo.isApprox(Eigen::Vector3f(0.2F, 0.3F, 0.4F)));
  EXPECT_TRUE(materialOf(world.scene, 1).albedo.isApprox(Eigen::Vector3f(0.5F, 0.6F, 0.7F)));
  EXPECT_TRUE(materialOf(world.scene, 2).albedo.isApprox(Eigen::Vector3f(0.13F, 0.44F, 0.7F)));
  EXPECT_TRUE(materialOf(world.scene, 3).emission.isApprox(Eigen::Vector3f(1.0F, 0.5F, 0.0F)));
  ASSERT_EQ(world.warnings.size(), 1U);
  EXPECT_TRUE(mentions(world.warnings, {"My/Plaid", " of e "}));
}

TEST(SdfWorld, ReadsAlbedoMapsAndTheModelsOwnScripts) {
  const TempFolder folder;
  folder.write("models/door/materials/textures/door.png", test::pngBytes(2, 2, 1, 2, 3));
  folder.write("models/door/materials/scripts/door.material",
               "material Door/Front\n{\n technique\n {\n pass\n {\n texture_unit\n {\n texture door.png\n "
               "}\n}\n}\n}\n");
  const std::string box = "<box><size>1 1 1</size></box>";
  const LoadedWorld world = load(
      folder,
      modelText(
          "a", visualText(box,
                          "<material><diffuse>0.5 0.5 0.5 1</diffuse><pbr><metal><albedo_map>"
                          "model://door/materials/textures/door.png</albedo_map></metal></pbr></material>")) +
          modelText("b", visualText(box,
                                    "<material><script><uri>model://door/materials/scripts</uri>"
                                    "<uri>model://door/materials/textures</uri><name>Door/Front</name>"
                                    "</script></material>")));
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  ASSERT_EQ(world.scene.textures.size(), 1U);  // one image, one texture
  EXPECT_EQ(materialOf(world.scene, 0).texture, 0);
  EXPECT_TRUE(materialOf(world.scene, 0).albedo.isApprox(Eigen::Vector3f::Constant(0.5F)));
  EXPECT_EQ(materialOf(world.scene, 1).texture, 0);
  EXPECT_TRUE(materialOf(world.scene, 1).albedo.isApprox(Eigen::Vector3f::Ones()));
}

TEST(SdfWorld, IncludesModelsWithTheirMeshes) {
  const TempFolder folder;
  folder.write("models/tri/model.config",
               "<?xml version='1.0'?><model><name>tri</name>"
               "<sdf version='1.6'>model.sdf</sdf></model>");
  folder.write(
      "models/tri/model.sdf",
      "<?xml version='1.0'?><sdf version='1.6'>" +
          modelText("tri", visualText(meshText("model://tri/meshes/tri.dae", "<scale>2 2 2</scale>")) +
                               collisionText(meshText("meshes/tri.dae", "<scale>2 2 2</scale>"))) +
          "</sdf>");
  folder.write("models/tri/meshes/tri.dae", test::daeText("Z_UP", "../../tri.png"));
  folder.write("models/tri/materials/textures/tri.png", test::pngBytes(2, 2, 1, 2, 3));
  const LoadedWorld world =
      load(folder,
           "<include><uri>model://tri</uri><name>first</name><pose>1 0 0 0 0 0</pose></include>"
           "<include><uri>model://tri</uri><name>second</name></include>");
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  EXPECT_TRUE(world.is_complete);
  const Scene& scene = world.scene;
  ASSERT_EQ(scene.models.size(), 2U);
  EXPECT_EQ(scene.models[0].name, "first");
  EXPECT_DOUBLE_EQ(scene.models[0].world_from_model.translation().x(), 1.0);
  ASSERT_EQ(scene.meshes.size(), 1U);
  EXPECT_EQ(scene.models[1].collisions.at(0).kind, Collision::Kind::kMesh);
  EXPECT_EQ(scene.models[1].collisions.at(0).mesh, 0);
  EXPECT_FLOAT_EQ(scene.meshes[0].vertices[1].norm(), 2.0F);
  EXPECT_EQ(materialOf(scene, 0).texture, 0);
  for (const char* file : {"test.world", "model.config", "model.sdf", "tri.dae", "tri.png"}) {
    EXPECT_TRUE(mentions(world.files, {file})) << file;
  }
}

TEST(SdfWorld, NamesWhatIsMissing) {
  const TempFolder folder;
  const LoadedWorld world =
      load(folder, "<include><uri>model://ghost</uri></include>" +
                       modelText("chair", visualText(meshText("model://chair/gone.dae"))) +
                       modelText("box", visualText("<box><size>1 1 1</size></box>",
                                                   "<material><pbr><metal><albedo_map>lost.png</albedo_map>"
                                                   "</metal></pbr></material>")));
  EXPECT_TRUE(mentions(world.warnings, {"model://ghost", "missing"}));
  EXPECT_TRUE(mentions(world.warnings, {"model://chair/gone.dae", "chair", "missing"}));
  EXPECT_TRUE(mentions(world.warnings, {"lost.png", "box", "missing"}));
  EXPECT_FALSE(world.is_complete);
  ASSERT_EQ(world.scene.models.size(), 1U);  // what is there is loaded
  EXPECT_EQ(world.scene.models[0].name, "box");
}

TEST(SdfWorld, ReadsLights) {
  const TempFolder folder;
  const LoadedWorld world = load(
      folder,
      "<light name='sun' type='directional'><cast_shadows>1</cast_shadows><pose>0 0 10 0 0 "
      "1.5707963267948966</pose>"
      "<diffuse>0.8 0.7 0.6 1</diffuse><direction>2 0 -2</direction></light>"
      "<light name='lamp' type='point'><pose>1 2 3 0 0 0</pose><diffuse>1 1 1 "
      "1</diffuse><cast_shadows>0</cast_shadows>"
      "<attenuation><range>12</range><constant>0.3</constant><linear>0.2</linear><quadratic>0.1</quadratic>"
      "</attenuation></light>" +
          modelText("desk",
                    "<light name='spot' type='spot'><pose>0 0 1 0 0 0</pose><direction>0 0 -1</direction>"
                    "<spot><inner_angle>0.3</inner_angle><outer_angle>0.9</outer_angle><falloff>1</falloff></"
                    "spot></light>",
                    "5 0 0 0 0 0") +
          "<scene><ambient>0.1 0.2 0.3 1</ambient><background>0.4 0.5 0.6 1</background></scene>");
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  ASSERT_EQ(world.scene.lights.size(), 3U);
  const auto named = [&](const std::string& name) {
    return *std::find_if(world.scene.lights.begin(), world.scene.lights.end(),
                         [&](const Light& light) { return light.name == name; });
  };
  const Light sun = named("sun");
  EXPECT_EQ(sun.kind, Light::Kind::kDirectional);
  EXPECT_TRUE(sun.color.isApprox(Eigen::Vector3f(0.8F, 0.7F, 0.6F)));
  // The light's own pose turns its direction.
  EXPECT_TRUE(sun.direction.isApprox(Eigen::Vector3d(0.0, std::sqrt(0.5), -std::sqrt(0.5)), 1e-9));
  EXPECT_TRUE(sun.casts_shadows);
  const Light lamp = named("lamp");
  EXPECT_EQ(lamp.kind, Light::Kind::kPoint);
  EXPECT_TRUE(lamp.position_m.isApprox(Eigen::Vector3d(1.0, 2.0, 3.0)));
  EXPECT_FALSE(lamp.casts_shadows);
  EXPECT_DOUBLE_EQ(lamp.range_m, 12.0);
  EXPECT_DOUBLE_EQ(lamp.attenuation_constant, 0.3);
  EXPECT_DOUBLE_EQ(lamp.attenuation_linear, 0.2);
  EXPECT_DOUBLE_EQ(lamp.attenuation_quadratic, 0.1);
  const Light spot = named("spot");
  EXPECT_EQ(spot.kind, Light::Kind::kSpot);
  EXPECT_TRUE(spot.position_m.isApprox(Eigen::Vector3d(5.0, 0.0, 1.0)));
  EXPECT_DOUBLE_EQ(spot.spot_inner_rad, 0.3);
  EXPECT_DOUBLE_EQ(spot.spot_outer_rad, 0.9);
  EXPECT_TRUE(world.scene.ambient.isApprox(Eigen::Vector3f(0.1F, 0.2F, 0.3F)));
  EXPECT_TRUE(world.scene.background.isApprox(Eigen::Vector3f(0.4F, 0.5F, 0.6F)));
}

TEST(SdfWorld, ReadsActors) {
  const TempFolder folder;
  const LoadedWorld world = load(
      folder,
      "<actor name='guest'><pose>1 2 0 0 0 "
      "0.5</pose><skin><filename>model://people/Sitting_man.dae</filename></skin>"
      "</actor>"
      "<actor name='clerk'><pose>3 2 0 0 0 0</pose><skin><filename>standing.dae</filename></skin></actor>"
      "<actor name='runner'><skin><filename>walk.dae</filename></skin><animation "
      "name='walk'><filename>walk.dae"
      "</filename></animation><script><loop>false</loop><delay_start>1.5</delay_start><auto_start>true</"
      "auto_start>"
      "<trajectory id='0' type='walk'><waypoint><time>0</time><pose>0 0 0 0 0 0</pose></waypoint>"
      "<waypoint><time>4</time><pose>2 1 0 0 0 1.0</pose></waypoint></trajectory></script></actor>");
  EXPECT_TRUE(world.warnings.empty()) << world.warnings.front();
  ASSERT_EQ(world.scene.people.size(), 3U);
  const Person& guest = world.scene.people[0];
  EXPECT_EQ(guest.posture, Posture::kSitting);
  ASSERT_EQ(guest.waypoints.size(), 1U);
  EXPECT_DOUBLE_EQ(guest.waypoints[0].world_from_person.y_m, 2.0);
  EXPECT_DOUBLE_EQ(guest.waypoints[0].world_from_person.yaw_rad, 0.5);
  EXPECT_EQ(world.scene.people[1].posture, Posture::kStanding);
  EXPECT_NE(world.scene.people[1].appearance, guest.appearance);
  const Person& runner = world.scene.people[2];
  EXPECT_EQ(runner.posture, Posture::kWalking);
  EXPECT_FALSE(runner.loop);
  EXPECT_DOUBLE_EQ(runner.start_delay_s, 1.5);
  ASSERT_EQ(runner.waypoints.size(), 2U);
  EXPECT_DOUBLE_EQ(runner.waypoints[1].time_s, 4.0);
  EXPECT_DOUBLE_EQ(runner.waypoints[1].world_from_person.x_m, 2.0);
  EXPECT_NEAR(runner.waypoints[1].world_from_person.yaw_rad, 1.0, 1e-9);
}

TEST(SdfWorld, NamesFileAndLineOfBrokenXml) {
  const TempFolder folder;
  const std::string path = folder.write("broken.world",
                                        "<?xml version='1.0'?>\n<sdf version='1.6'>\n<world name='w'>\n"
                                        "<model>\n</world>\n</sdf>\n");
  const std::string error = errorOf(path);
  EXPECT_NE(error.find(path + ":"), std::string::npos) << error;
  // The parser names the line of the element that stays open.
  EXPECT_NE(error.find(":4:"), std::string::npos) << error;
}

TEST(SdfWorld, NamesFileAndLineOfABrokenIncludedModel) {
  const TempFolder folder;
  folder.write("models/tri/model.config",
               "<?xml version='1.0'?><model><name>tri</name><sdf version='1.6'>model.sdf</sdf></model>");
  const std::string model =
      folder.write("models/tri/model.sdf", "<?xml version='1.0'?>\n<sdf version='1.6'>\n<model>\n</sdf>\n");
  const LoadedWorld world = load(folder, "<include><uri>model://tri</uri></include>" +
                                             modelText("box", visualText("<box><size>1 1 1</size></box>")));
  EXPECT_TRUE(mentions(world.warnings, {model + ":3:"}));
  EXPECT_EQ(world.scene.models.size(), 1U);
}

TEST(SdfWorld, NamesAMissingFileAndAMissingWorld) {
  const TempFolder folder;
  EXPECT_NE(errorOf(folder.path("none.world")).find("none.world"), std::string::npos);
  EXPECT_NE(errorOf(folder.path()).find(folder.path()), std::string::npos);
  const std::string empty = folder.write("empty.world", "<?xml version='1.0'?><sdf version='1.6'></sdf>");
  EXPECT_NE(errorOf(empty).find(empty + " has no <world>"), std::string::npos);
  const std::string urdf = folder.write("robot.urdf", "<robot name='r'><link name='base_link'/></robot>");
  EXPECT_NE(errorOf(urdf).find(urdf + ":1: begins with <robot>"), std::string::npos);
}

TEST(SdfWorld, NamesOnceWhatIsNotSimulated) {
  const TempFolder folder;
  const LoadedWorld world =
      load(folder,
           "<plugin name='weather' filename='libweather.so'/><gui><plugin name='view' "
           "filename='libview.so'/></gui>"
           "<model name='door'><link name='frame'/><link name='leaf'>"
           "<visual name='v'><geometry><polyline><point>0 0</point><point>1 0</point><point>0 "
           "1</point><height>1</height>"
           "</polyline></geometry></visual><sensor name='eye' type='camera'/></link>"
           "<joint name='hinge' type='revolute'><parent>frame</parent><child>leaf</child><axis><xyz>0 0 "
           "1</xyz></axis></joint>"
           "<joint name='screw' type='fixed'><parent>frame</parent><child>leaf</child></joint>"
           "<plugin name='opener' filename='libdoor.so'/></model>"
           "<model name='hill'><static>1</static><link name='l'><collision name='c'><geometry><heightmap>"
           "<uri>h.png</uri></heightmap></geometry></collision><visual "
           "name='v'><geometry><heightmap><uri>h.png</uri>"
           "</heightmap></geometry></visual></link></model>"
           "<teleporter>on</teleporter>");
  const auto& warnings = world.warnings;
  EXPECT_TRUE(mentions(warnings, {"plugin weather of the world is not simulated"}));
  EXPECT_TRUE(mentions(warnings, {"revolute joint hinge of door is not simulated"}));
  EXPECT_TRUE(mentions(warnings, {"plugin opener of door is not simulated"}));
  EXPECT_TRUE(mentions(warnings, {"sensor eye of door is not simulated"}));
  EXPECT_TRUE(mentions(warnings, {"polyline of door is not simulated"}));
  EXPECT_TRUE(mentions(warnings, {"teleporter"}));
  EXPECT_EQ(std::count(warnings.begin(), warnings.end(), "shape heightmap of hill is not simulated"), 1);
  EXPECT_FALSE(mentions(warnings, {"screw"}));
  EXPECT_FALSE(mentions(warnings, {"view"}));
}

TEST(SdfWorld, LoadsDespiteErrorsOfTheParser) {
  const TempFolder folder;
  const LoadedWorld world =
      load(folder,
           "<model name='odd'><link name='l'><inertial><mass>1</mass><inertia><ixx>-1</ixx><iyy>1</iyy>"
           "<izz>1</izz></inertia></inertial><visual name='v'><geometry><sphere><radius>1</radius></sphere>"
           "</geometry></visual></link></model>" +
               modelText("fine", visualText("<box><size>1 1 1</size></box>")));
  EXPECT_FALSE(world.warnings.empty());
  ASSERT_EQ(world.scene.models.size(), 2U);
}

TEST(SdfWorld, LoadsTheWorldsOfThisPackage) {
  for (const char* name : {"empty", "lab", "corridor"}) {
    const LoadedWorld world =
        loadWorld(std::string(FRUGAL_NAV_SOURCE_DIR) + "/worlds/" + name + ".world", ResourcePath());
    EXPECT_TRUE(world.warnings.empty()) << name << ": " << world.warnings.front();
    EXPECT_TRUE(world.is_complete) << name;
    EXPECT_FALSE(world.scene.models.empty()) << name;
  }
}

}  // namespace
}  // namespace frugal_nav::sim
