#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/eval/json.hpp>

namespace frugal_nav::eval {

/// A run of a suite, as its file holds it.
struct Result {
  std::string suite;
  std::string version;  ///< of the package that measured
  std::uint64_t seed = 0;
  Json options = Json::object();  ///< every option of the suite, and "trials"
  Rows rows;
  Json summary = Json::object();
};

/// The JSON text of a result, one row a line.
std::string toJsonText(const Result& result);

/// The rows as CSV with one header line; a value that does not exist is an empty field.
std::string toCsvText(const Rows& rows);

/// Reads a result's file; throws ConfigError naming the file and what is wrong with it.
Result readResult(const std::string& path);

/// Writes OUT/SUITE.json and OUT/SUITE.csv, making OUT; an OUT that ends in .json names the file itself.
/// Returns the JSON file's path; throws ConfigError.
std::string writeResult(const Result& result, const std::string& out);

/// Joins the shards of one run: every trial exactly once, the summary computed from all rows.
/// Throws ConfigError when they are not of one run, overlap, or leave a trial out.
Result mergeResults(const std::vector<Result>& shards);

/// The summary as a table for people.
std::string toTable(const Result& result);

}  // namespace frugal_nav::eval
