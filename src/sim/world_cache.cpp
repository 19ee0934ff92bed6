#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include <unistd.h>

#include <frugal_nav/sim/scene_archive.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;

// Raised whenever the loader or the format changes, so that older files are made again.
constexpr std::uint64_t kVersion = 1;
constexpr std::uint64_t kMagic = 0x656e656373766e66ULL;

/// FNV-1a over words of eight bytes: a scene with its textures can be hundreds of megabytes.
std::uint64_t hashOf(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325ULL) {
  for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min(sizeof(word), bytes.size() - i));
    hash = (hash ^ word) * 0x100000001b3ULL;
    hash ^= hash >> 32U;  // the multiplication alone never carries a high bit down
  }
  return (hash ^ bytes.size()) * 0x100000001b3ULL;
}

std::optional<std::string> readFile(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) return std::nullopt;
  std::string bytes(static_cast<std::size_t>(stream.tellg()), '\0');
  stream.seekg(0);
  if (!stream.read(&bytes[0], static_cast<std::streamsize>(bytes.size()))) return std::nullopt;
  return bytes;
}

/// Size and time of the files beside the world itself, as one number; it is zero when one is gone.
std::uint64_t stampOf(const std::vector<std::string>& files, const std::string& world_path) {
  std::uint64_t stamp = hashOf("files");
  for (const std::string& file : files) {
    if (file == world_path) continue;
    std::error_code error;
    const auto size = fs::file_size(file, error);
    if (error) return 0;
    const auto time = fs::last_write_time(file, error).time_since_epoch().count();
    if (error) return 0;
    stamp = hashOf(file + ' ' + std::to_string(size) + ' ' + std::to_string(time), stamp);
  }
  return stamp;
}

/// What stands before the scene's bytes.
struct Header {
  std::uint64_t magic = kMagic;
  std::uint64_t version = kVersion;
  std::uint64_t world_hash = 0;
  std::uint64_t files_stamp = 0;
  std::uint64_t scene_hash = 0;
};

std::optional<LoadedWorld> readCache(const fs::path& cache, std::uint64_t world_hash,
                                     const std::string& world_path) {
  auto bytes = readFile(cache);
  Header header;
  if (!bytes || bytes->size() < sizeof(header)) return std::nullopt;
  std::memcpy(&header, bytes->data(), sizeof(header));
  if (header.magic != kMagic || header.version != kVersion || header.world_hash != world_hash) {
    return std::nullopt;
  }
  bytes->erase(0, sizeof(header));
  if (hashOf(*bytes) != header.scene_hash) return std::nullopt;
  auto world = fromBytes(*bytes);
  if (!world || stampOf(world->files, world_path) != header.files_stamp) return std::nullopt;
  return world;
}

/// Writes under a name of its own first: a reader sees the old file or the whole new one.
void writeCache(const fs::path& cache, std::uint64_t world_hash, const std::string& world_path,
                const LoadedWorld& world) {
  std::error_code error;
  fs::create_directories(cache.parent_path(), error);
  std::string temporary = cache.string() + ".XXXXXX";
  const int descriptor = mkstemp(&temporary[0]);
  if (descriptor < 0) return;
  close(descriptor);

  const std::string bytes = toBytes(world);
  Header header;
  header.world_hash = world_hash;
  header.files_stamp = stampOf(world.files, world_path);
  header.scene_hash = hashOf(bytes);
  std::ofstream stream(temporary, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(&header), sizeof(header));
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (stream) fs::rename(temporary, cache, error);
  if (!stream || error) fs::remove(temporary, error);
}

std::string cacheName(const std::string& world_path, const ResourcePath& resources) {
  std::string key = world_path;
  for (const auto* folders : {&resources.modelFolders(), &resources.packageFolders()}) {
    for (const std::string& folder : *folders) key += '\n' + folder;
    key += '\n';
  }
  std::ostringstream name;
  name << fs::path(world_path).stem().string() << '-' << std::hex << hashOf(key) << ".scene";
  return name.str();
}

}  // namespace

LoadedWorld loadWorldCached(const std::string& path, const ResourcePath& resources,
                            const std::string& cache_folder) {
  if (cache_folder.empty() || !fs::is_regular_file(path)) return loadWorld(path, resources);
  const auto world_bytes = readFile(path);
  if (!world_bytes) return loadWorld(path, resources);
  const std::string world_path = fs::absolute(path).lexically_normal().string();
  const fs::path cache = fs::path(cache_folder) / cacheName(world_path, resources);
  const std::uint64_t world_hash = hashOf(*world_bytes);
  if (auto cached = readCache(cache, world_hash, world_path)) return std::move(*cached);
  LoadedWorld world = loadWorld(path, resources);
  if (world.is_complete) writeCache(cache, world_hash, world_path, world);
  return world;
}

std::string defaultCacheFolder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache != '\0') return (fs::path(cache) / "frugal_nav").string();
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return (fs::path(home) / ".cache" / "frugal_nav").string();
  return {};
}

}  // namespace frugal_nav::sim
