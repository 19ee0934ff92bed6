#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <frugal_nav/eval/result.hpp>
#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {
namespace {

constexpr const char* kKeys[] = {"suite", "version", "seed", "options", "rows", "summary"};

std::string csvField(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::vector<std::string> columnsOf(const Rows& rows) {
  std::vector<std::string> columns;
  for (const Json& row : rows) {
    for (const auto& item : row.items()) {
      if (std::find(columns.begin(), columns.end(), item.key()) == columns.end())
        columns.push_back(item.key());
    }
  }
  return columns;
}

void writeFile(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw ConfigError("cannot write " + path.string());
}

/// The options of the suite as configure() takes them; "trials" belongs to the run.
ParamTree treeOf(const Json& options) {
  ParamTree tree;
  for (const auto& item : options.items()) {
    if (item.key() == "trials") continue;
    const Json& value = item.value();
    if (value.is_boolean()) tree[item.key()] = value.get<bool>();
    if (value.is_number_integer()) tree[item.key()] = value.get<int>();
    if (value.is_number_float()) tree[item.key()] = value.get<double>();
    if (value.is_string()) tree[item.key()] = value.get<std::string>();
    if (value.is_array() && !value.empty() && value[0].is_number())
      tree[item.key()] = value.get<std::vector<double>>();
    else if (value.is_array())
      tree[item.key()] = value.get<std::vector<std::string>>();
  }
  return tree;
}

std::set<int> trialsIn(const Rows& rows) {
  std::set<int> trials;
  for (const Json& row : rows) trials.insert(row.at("trial").get<int>());
  return trials;
}

void requireSameRun(const Result& a, const Result& b) {
  const auto refuse = [](const std::string& what, const Json& one, const Json& other) {
    throw ConfigError("cannot merge: the files' " + what + " differ: " + one.dump() + " and " + other.dump());
  };
  if (a.suite != b.suite) refuse("suites", a.suite, b.suite);
  if (a.version != b.version) refuse("versions", a.version, b.version);
  if (a.seed != b.seed) refuse("seeds", a.seed, b.seed);
  if (a.options != b.options) refuse("options", a.options, b.options);
}

std::string tableValue(const Json& value) {
  if (value.is_null()) return "-";
  if (!value.is_number_float()) return value.is_string() ? value.get<std::string>() : value.dump();
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value.get<double>());
  return text;
}

}  // namespace

std::string toJsonText(const Result& result) {
  std::ostringstream text;
  text << "{\"suite\": " << Json(result.suite) << ", \"version\": " << Json(result.version)
       << ", \"seed\": " << result.seed << ",\n\"options\": " << result.options << ",\n\"rows\": [";
  for (std::size_t i = 0; i < result.rows.size(); ++i) text << (i == 0 ? "\n" : ",\n") << result.rows[i];
  text << "\n],\n\"summary\": " << result.summary.dump(2) << "}\n";
  return text.str();
}

std::string toCsvText(const Rows& rows) {
  const std::vector<std::string> columns = columnsOf(rows);
  std::ostringstream text;
  for (std::size_t i = 0; i < columns.size(); ++i) text << (i == 0 ? "" : ",") << csvField(columns[i]);
  text << "\n";
  for (const Json& row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      text << (i == 0 ? "" : ",") << (row.contains(columns[i]) ? csvField(row[columns[i]]) : "");
    }
    text << "\n";
  }
  return text.str();
}

Result readResult(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError("cannot read " + path);
  try {
    const Json json = Json::parse(file);
    for (const char* key : kKeys) {
      if (!json.contains(key))
        throw ConfigError(path + ": no key \"" + key + "\"; evaluate writes such files");
    }
    Result result{json.at("suite"), json.at("version"), json.at("seed"), json.at("options"), {}, {}};
    result.rows = json.at("rows").get<Rows>();
    result.summary = json.at("summary");
    trialsIn(result.rows);
    return result;
  } catch (const nlohmann::json::exception& error) {
    throw ConfigError(path + ": not a result of evaluate: " + error.what());
  }
}

std::string writeResult(const Result& result, const std::string& out) {
  std::filesystem::path json(out);
  if (json.extension() != ".json") json /= result.suite + ".json";
  if (json.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(json.parent_path(), error);
    if (error)
      throw ConfigError("cannot make the folder " + json.parent_path().string() + ": " + error.message());
  }
  writeFile(json, toJsonText(result));
  writeFile(std::filesystem::path(json).replace_extension(".csv"), toCsvText(result.rows));
  return json.string();
}

Result mergeResults(const std::vector<Result>& shards) {
  if (shards.empty()) throw ConfigError("cannot merge: no files given");
  Result merged = shards.front();
  std::set<int> seen = trialsIn(merged.rows);
  for (std::size_t i = 1; i < shards.size(); ++i) {
    requireSameRun(merged, shards[i]);
    for (const int trial : trialsIn(shards[i].rows)) {
      if (!seen.insert(trial).second)
        throw ConfigError("cannot merge: trial " + std::to_string(trial) + " is in two of the files");
    }
    merged.rows.insert(merged.rows.end(), shards[i].rows.begin(), shards[i].rows.end());
  }
  const int trials = merged.options.at("trials");
  for (int k = 0; k < trials; ++k) {
    if (seen.count(k) == 0)
      throw ConfigError("cannot merge: trial " + std::to_string(k) + " is in none of the files");
  }
  std::stable_sort(merged.rows.begin(), merged.rows.end(),
                   [](const Json& a, const Json& b) { return a.at("trial") < b.at("trial"); });
  const std::unique_ptr<Suite> suite = makeSuite(merged.suite);
  suite->configure(treeOf(merged.options));
  merged.summary = suite->summarise(merged.rows);
  return merged;
}

std::string toTable(const Result& result) {
  std::size_t width = 0;
  for (const auto& item : result.summary.items()) width = std::max(width, item.key().size());
  std::ostringstream text;
  text << result.suite << ": " << trialsIn(result.rows).size() << " trials, seed " << result.seed << "\n";
  for (const auto& item : result.summary.items()) {
    text << "  " << item.key() << std::string(width - item.key().size() + 2, ' ') << tableValue(item.value())
         << "\n";
  }
  return text.str();
}

}  // namespace frugal_nav::eval
