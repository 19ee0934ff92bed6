#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/sim/mesh_file.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;

/// Opens files as assimp does, and remembers which.
class RecordingFiles : public Assimp::DefaultIOSystem {
 public:
  explicit RecordingFiles(std::vector<std::string>& files) : files_(files) {}
  Assimp::IOStream* Open(const char* path, const char* mode) override {
    Assimp::IOStream* stream = DefaultIOSystem::Open(path, mode);
    if (stream != nullptr && std::find(files_.begin(), files_.end(), path) == files_.end()) {
      files_.emplace_back(path);
    }
    return stream;
  }

 private:
  std::vector<std::string>& files_;
};

bool isGltf(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".gltf" || extension == ".glb";
}

Texture toTexture(const std::string& name, const cv::Mat& bgr) {
  constexpr int kLargestSide = 1024;  // 3 MB; finer than a 640x480 camera resolves indoors
  cv::Mat rgb;
  const double shrink = static_cast<double>(kLargestSide) / std::max(bgr.cols, bgr.rows);
  if (shrink < 1.0) {
    cv::resize(bgr, rgb, {}, shrink, shrink, cv::INTER_AREA);
    cv::cvtColor(rgb, rgb, cv::COLOR_BGR2RGB);
  } else {
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  }
  return {name, rgb.cols, rgb.rows, {rgb.datastart, rgb.dataend}};
}

/// A texture that the mesh file itself holds: a compressed image, or plain texels when its height is given.
std::optional<Texture> embeddedTexture(const std::string& name, const aiTexture& texture) {
  if (texture.mHeight == 0) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(texture.pcData);
    const cv::Mat image =
        cv::imdecode(std::vector<std::uint8_t>(bytes, bytes + texture.mWidth), cv::IMREAD_COLOR);
    return image.empty() ? std::nullopt : std::optional<Texture>(toTexture(name, image));
  }
  cv::Mat image(static_cast<int>(texture.mHeight), static_cast<int>(texture.mWidth), CV_8UC3);
  for (int i = 0; i < image.rows * image.cols; ++i) {
    const aiTexel& texel = texture.pcData[i];
    image.at<cv::Vec3b>(i / image.cols, i % image.cols) = {texel.b, texel.g, texel.r};
  }
  return toTexture(name, image);
}

float toSrgb(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1.0F / 2.4F) - 0.055F;
}

/// Turns what assimp read into a MeshFile.
class Converter {
 public:
  Converter(const std::string& path, const aiScene& scene, const ResourcePath& resources, MeshFile& result)
      : path_(path), is_gltf_(isGltf(path)), scene_(scene), resources_(resources), result_(result) {}

  void addMaterials() {
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) {
      result_.materials.push_back(convert(*scene_.mMaterials[i]));
    }
  }

  void addMeshes(const std::string& submesh) {
    aiMatrix4x4 up;
    if (is_gltf_) aiMatrix4x4::RotationX(static_cast<float>(M_PI / 2.0), up);
    addNode(*scene_.mRootNode, up, submesh);
  }

 private:
  Material convert(const aiMaterial& source) {
    Material material;
    material.name = source.GetName().C_Str();
    material.albedo = color(source, AI_MATKEY_COLOR_DIFFUSE, material.albedo);
    material.emission = color(source, AI_MATKEY_COLOR_EMISSIVE, material.emission);
    material.texture = addTexture(source);
    // OBJ and DAE files with a texture often carry a meaningless colour beside it, black even.
    if (material.texture >= 0 && !is_gltf_) material.albedo = Eigen::Vector3f::Ones();
    return material;
  }

  Eigen::Vector3f color(const aiMaterial& source, const char* key, unsigned type, unsigned index,
                        const Eigen::Vector3f& otherwise) const {
    aiColor4D read;
    if (source.Get(key, type, index, read) != aiReturn_SUCCESS) return otherwise;
    Eigen::Vector3f rgb(read.r, read.g, read.b);
    if (!rgb.allFinite()) return otherwise;
    rgb = rgb.cwiseMax(0.0F).cwiseMin(1.0F);
    return is_gltf_ ? rgb.unaryExpr(&toSrgb) : rgb;
  }

  int addTexture(const aiMaterial& source) {
    aiString name;
    if (source.GetTexture(aiTextureType_DIFFUSE, 0, &name) != aiReturn_SUCCESS &&
        source.GetTexture(aiTextureType_BASE_COLOR, 0, &name) != aiReturn_SUCCESS) {
      return -1;
    }
    const auto known = texture_of_.find(name.C_Str());
    if (known != texture_of_.end()) return known->second;
    int& index = texture_of_[name.C_Str()];
    index = -1;
    if (auto texture = load(name.C_Str())) {
      index = static_cast<int>(result_.textures.size());
      result_.textures.push_back(std::move(*texture));
    } else {
      result_.warnings.push_back("texture " + std::string(name.C_Str()) + " of " + path_ +
                                 " is missing or no image");
    }
    return index;
  }

  std::optional<Texture> load(const std::string& name) {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      return embeddedTexture(path_ + "#" + name, *embedded);
    }
    const auto found = findTexture(name, fs::path(path_).parent_path().string(), resources_);
    if (!found) return std::nullopt;
    result_.files.push_back(*found);
    return readTexture(*found);
  }

  void addNode(const aiNode& node, const aiMatrix4x4& parent, const std::string& submesh) {
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const aiMesh& mesh = *scene_.mMeshes[node.mMeshes[i]];
      const bool is_wanted = submesh.empty() || submesh == mesh.mName.C_Str() ||
                             submesh == node.mName.C_Str() || submesh + "-mesh" == mesh.mName.C_Str();
      if (is_wanted) addMesh(mesh, transform);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) addNode(*node.mChildren[i], transform, submesh);
  }

  void addMesh(const aiMesh& source, const aiMatrix4x4& transform) {
    Mesh& mesh = result_.mesh;
    const auto first = static_cast<int>(mesh.vertices.size());
    aiMatrix3x3 normal_transform(transform);
    normal_transform.Inverse().Transpose();
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      const aiVector3D p = transform * source.mVertices[i];
      mesh.vertices.emplace_back(p.x, p.y, p.z);
      // Absent normals are zero here: cleanMesh computes them.
      const aiVector3D n = source.HasNormals() ? normal_transform * source.mNormals[i] : aiVector3D();
      const Eigen::Vector3f normal(n.x, n.y, n.z);
      mesh.normals.push_back(normal.allFinite() ? normal.normalized() : Eigen::Vector3f::Zero());
      const aiVector3D uv = source.HasTextureCoords(0) ? source.mTextureCoords[0][i] : aiVector3D();
      mesh.uvs.emplace_back(uv.x, uv.y);
    }
    const bool is_mirrored = transform.Determinant() < 0.0F;
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
      const aiFace& face = source.mFaces[i];
      if (face.mNumIndices != 3) continue;
      Eigen::Vector3i triangle(static_cast<int>(face.mIndices[0]), static_cast<int>(face.mIndices[1]),
                               static_cast<int>(face.mIndices[2]));
      if (is_mirrored) std::swap(triangle.y(), triangle.z());
      mesh.triangles.emplace_back(triangle.array() + first);
      mesh.triangle_material.push_back(static_cast<int>(source.mMaterialIndex));
    }
  }

  const std::string path_;
  const bool is_gltf_;
  const aiScene& scene_;
  const ResourcePath& resources_;
  MeshFile& result_;
  std::map<std::string, int> texture_of_;
};

void center(Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  const Eigen::Vector3f middle = box.center();
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex -= middle;
}

}  // namespace

MeshFile readMeshFile(const std::string& path, const Submesh& submesh, const ResourcePath& resources) {
  MeshFile result;
  Assimp::Importer importer;
  importer.SetIOHandler(new RecordingFiles(result.files));  // the importer deletes it
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error("mesh " + path + " cannot be read: " + importer.GetErrorString());
  }
  Converter converter(path, *scene, resources, result);
  converter.addMaterials();
  converter.addMeshes(submesh.name);
  cleanMesh(result.mesh);
  if (result.mesh.triangles.empty()) {
    throw std::runtime_error("mesh " + path + " has no triangles" +
                             (submesh.name.empty() ? "" : " in its part " + submesh.name));
  }
  if (!submesh.name.empty() && submesh.is_centered) center(result.mesh);
  return result;
}

std::optional<Texture> readTexture(const std::string& path) {
  const cv::Mat image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) return std::nullopt;
  return toTexture(path, image);
}

void scaleMesh(Mesh& mesh, const Eigen::Vector3d& scale) {
  const Eigen::Array3f factor = scale.cast<float>();
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex.array() *= factor;
  for (Eigen::Vector3f& normal : mesh.normals) normal = (normal.array() / factor).matrix().normalized();
  if (scale.prod() < 0.0) {
    for (Eigen::Vector3i& triangle : mesh.triangles) std::swap(triangle.y(), triangle.z());
  }
}

}  // namespace frugal_nav::sim
