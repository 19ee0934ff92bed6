#include <cstring>

#include <gtest/gtest.h>
#include <support/temp_folder.hpp>
#include <unit/sim/world_files.hpp>

#include <frugal_nav/sim/mesh_file.hpp>

namespace frugal_nav::sim {
namespace {

using frugal_nav::test::TempFolder;

std::string mtlText(const std::string& image) { return "newmtl wood\nKd 0 0 0\nmap_Kd " + image + "\n"; }

const char* const kObjSquare =
    "mtllib square.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 2\nv 0 0 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl wood\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

void appendWord(std::string& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof(word));
}

/// A glTF binary: a triangle (0 0 0), (1 0 0), (0 1 0) whose texture is embedded.
std::string glbBytes(const std::string& png) {
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const float uvs[] = {0, 1, 1, 1, 0, 0};  // glTF's v points down
  std::string data(reinterpret_cast<const char*>(positions), sizeof(positions));
  data.append(reinterpret_cast<const char*>(uvs), sizeof(uvs));
  data += png;
  const std::string png_size = std::to_string(png.size());
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"part"}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],)"
      R"("textures":[{"source":0}],"images":[{"bufferView":2,"mimeType":"image/png"}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],)"
      R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)"
      R"({"buffer":0,"byteOffset":60,"byteLength":)" +
      png_size + R"(}],"buffers":[{"byteLength":)" + std::to_string(data.size()) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  data.resize((data.size() + 3) / 4 * 4, '\0');
  std::string glb = "glTF";
  appendWord(glb, 2);
  appendWord(glb, 12 + 8 + json.size() + 8 + data.size());
  appendWord(glb, json.size());
  glb += "JSON" + json;
  appendWord(glb, data.size());
  glb += std::string("BIN\0", 4) + data;
  return glb;
}

Eigen::Vector3f sizeOf(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  return box.sizes();
}

TEST(MeshFile, ReadsADaeInMetresWithItsOwnAxes) {
  const TempFolder folder;
  for (const char* up_axis : {"Z_UP", "Y_UP"}) {
    const MeshFile file = readMeshFile(folder.write("tri.dae", test::daeText(up_axis)), {}, {});
    EXPECT_TRUE(sizeOf(file.mesh).isApprox(Eigen::Vector3f(1.0F, 0.0F, 1.0F), 1e-5F)) << up_axis;
    ASSERT_EQ(file.mesh.triangles.size(), 1U);
    // (1 0 0) x (0 0 1) looks along -y.
    EXPECT_TRUE(file.mesh.normals[0].isApprox(Eigen::Vector3f(0.0F, -1.0F, 0.0F), 1e-5F));
    const auto material = static_cast<std::size_t>(file.mesh.triangle_material[0]);
    EXPECT_TRUE(file.materials[material].albedo.isApprox(Eigen::Vector3f(0.2F, 0.4F, 0.6F), 1e-3F));
    EXPECT_TRUE(file.warnings.empty());
  }
}

TEST(MeshFile, FindsATextureWithOneFolderUpTooMany) {
  const TempFolder folder;
  folder.write("house/chair/materials/textures/oak.png", test::pngBytes(8, 4, 200, 100, 50));
  const std::string dae =
      folder.write("house/chair/meshes/chair.dae", test::daeText("Z_UP", "../../materials/textures/oak.png"));
  const MeshFile file = readMeshFile(dae, {}, {});
  EXPECT_TRUE(file.warnings.empty());
  ASSERT_EQ(file.textures.size(), 1U);
  EXPECT_EQ(file.textures[0].width_px, 8);
  EXPECT_EQ(file.textures[0].height_px, 4);
  EXPECT_EQ(file.textures[0].rgb[0], 200);
  EXPECT_EQ(file.textures[0].rgb[2], 50);
  EXPECT_TRUE(test::mentions(file.files, {"oak.png"}));
  EXPECT_TRUE(test::mentions(file.files, {"chair.dae"}));
}

TEST(MeshFile, NamesAMissingTexture) {
  const TempFolder folder;
  const MeshFile file = readMeshFile(folder.write("tri.dae", test::daeText("Z_UP", "gone.png")), {}, {});
  EXPECT_TRUE(test::mentions(file.warnings, {"gone.png", "tri.dae"}));
  EXPECT_EQ(file.mesh.triangles.size(), 1U);
}

TEST(MeshFile, ReadsAnObjWhoseColourBesideTheTextureIsBlack) {
  const TempFolder folder;
  folder.write("square.mtl", mtlText("wood.png"));
  folder.write("wood.png", test::pngBytes(2, 2, 10, 20, 30));
  const MeshFile file = readMeshFile(folder.write("square.obj", kObjSquare), {}, {});
  EXPECT_EQ(file.mesh.triangles.size(), 2U);
  EXPECT_TRUE(sizeOf(file.mesh).isApprox(Eigen::Vector3f(1.0F, 0.0F, 2.0F)));
  const Material& material = file.materials[static_cast<std::size_t>(file.mesh.triangle_material[0])];
  EXPECT_GE(material.texture, 0);
  EXPECT_TRUE(material.albedo.isApprox(Eigen::Vector3f::Ones()));
  EXPECT_TRUE(test::mentions(file.files, {"square.mtl"}));
  for (std::size_t i = 0; i < file.mesh.vertices.size(); ++i) {  // v up: the texture's bottom is at z = 0
    EXPECT_NEAR(file.mesh.uvs[i].y(), file.mesh.vertices[i].z() / 2.0F, 1e-6F);
  }
}

TEST(MeshFile, ReadsAnStl) {
  const TempFolder folder;
  const MeshFile file =
      readMeshFile(folder.write("tri.stl",
                                "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                "vertex 0 1 0\nendloop\nendfacet\nendsolid t\n"),
                   {}, {});
  ASSERT_EQ(file.mesh.triangles.size(), 1U);
  EXPECT_TRUE(file.mesh.normals[0].isApprox(Eigen::Vector3f::UnitZ()));
}

TEST(MeshFile, ReadsAGlbWithAnEmbeddedTextureAndTurnsItUp) {
  const TempFolder folder;
  const MeshFile file =
      readMeshFile(folder.write("tri.glb", glbBytes(test::pngBytes(4, 4, 250, 120, 10))), {}, {});
  EXPECT_TRUE(file.warnings.empty());
  ASSERT_EQ(file.textures.size(), 1U);
  EXPECT_EQ(file.textures[0].rgb[0], 250);
  EXPECT_EQ(file.textures[0].rgb[2], 10);
  EXPECT_TRUE(sizeOf(file.mesh).isApprox(Eigen::Vector3f(1.0F, 0.0F, 1.0F), 1e-5F));
  for (std::size_t i = 0; i < file.mesh.vertices.size(); ++i) {
    EXPECT_NEAR(file.mesh.uvs[i].y(), file.mesh.vertices[i].z(), 1e-5F);
  }
}

TEST(MeshFile, TakesOnePartAndCentresIt) {
  const TempFolder folder;
  const std::string path = folder.write(
      "parts.obj",
      "o left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no right\nv 5 0 0\nv 7 0 0\nv 5 1 0\nf 4 5 6\n");
  EXPECT_EQ(readMeshFile(path, {}, {}).mesh.triangles.size(), 2U);
  const MeshFile right = readMeshFile(path, {"right", true}, {});
  ASSERT_EQ(right.mesh.triangles.size(), 1U);
  EXPECT_FLOAT_EQ(right.mesh.vertices[0].x(), -1.0F);
  EXPECT_THROW(readMeshFile(path, {"middle", false}, {}), std::runtime_error);
}

TEST(MeshFile, NamesAFileThatIsNoMesh) {
  const TempFolder folder;
  const std::string path = folder.write("tri.dae", "this is no mesh");
  try {
    readMeshFile(path, {}, {});
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
  }
}

TEST(MeshFile, ShrinksLargeTextures) {
  const TempFolder folder;
  const auto texture = readTexture(folder.write("large.png", test::pngBytes(3000, 1500, 9, 8, 7)));
  ASSERT_TRUE(texture);
  EXPECT_EQ(texture->width_px, 1024);
  EXPECT_EQ(texture->height_px, 512);
  EXPECT_EQ(texture->rgb.size(), 1024U * 512U * 3U);
  EXPECT_FALSE(readTexture(folder.write("broken.png", "no image")));
}

TEST(CleanMesh, DropsDoubledFacesAndMakesTheirNormalsWorthSomething) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.normals.assign(5, Eigen::Vector3f::Zero());  // what averaging both sides gives
  mesh.uvs.assign(5, Eigen::Vector2f::Zero());
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 4}, {3, 2, 4}, {0, 1, 1}};
  mesh.triangle_material = {1, 2, 3, 4, 5};
  cleanMesh(mesh);
  EXPECT_EQ(mesh.triangle_material, (std::vector<int>{1, 2}));
  for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_TRUE(normal.isApprox(Eigen::Vector3f::UnitZ()));
}

TEST(CleanMesh, KeepsEdgesSharpAndCurvesSmooth) {
  // Two strips that meet at the y axis under a given angle.
  const auto bent = [](float angle) {
    Mesh mesh;
    const float x = std::cos(angle);
    const float z = std::sin(angle);
    mesh.vertices = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {x, 0, z}};
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
    mesh.triangle_material = {0, 0};
    cleanMesh(mesh);
    return mesh.normals[1].dot(mesh.normals[3]);  // corner 1 as seen from either triangle
  };
  EXPECT_NEAR(bent(0.3F), 1.0F, 1e-5F);
  EXPECT_NEAR(bent(1.5F), std::cos(1.5F), 1e-5F);
}

TEST(CleanMesh, KeepsSoundNormals) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Eigen::Vector3f smooth = Eigen::Vector3f(0.1F, 0.0F, 1.0F).normalized();
  mesh.normals.assign(3, smooth);
  mesh.triangles = {{0, 1, 2}};
  mesh.triangle_material = {0};
  cleanMesh(mesh);
  EXPECT_TRUE(mesh.normals[2].isApprox(smooth));
}

TEST(ScaleMesh, MirroringKeepsTheOutside) {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, Eigen::Vector3f::UnitZ());
  mesh.triangles = {{0, 1, 2}};
  scaleMesh(mesh, {-2.0, 3.0, 1.0});
  EXPECT_TRUE(mesh.vertices[1].isApprox(Eigen::Vector3f(-2.0F, 0.0F, 0.0F)));
  const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[0][i])]; };
  EXPECT_GT((at(1) - at(0)).cross(at(2) - at(0)).dot(mesh.normals[0]), 0.0F);
}

}  // namespace
}  // namespace frugal_nav::sim
