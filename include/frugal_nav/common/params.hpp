#pragma once

#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace frugal_nav {

/// A wrong configuration: the message names the thing and what to do. Thrown before anything moves.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A parameter's value as files and the parameter server hold it.
using ParamValue =
    std::variant<bool, int, double, std::string, std::vector<double>, std::vector<std::string>>;

/// Parameters by their path ("limits/max_v_mps"): what a YAML file or the parameter server holds.
using ParamTree = std::map<std::string, ParamValue>;

/// What is to be known of one parameter, said once, where the params struct lists its fields.
struct Field {
  const char* unit = "";    ///< "m", "rad/s", "" for a pure number
  const char* reason = "";  ///< why it exists and how its default was chosen
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  const char* choices = "";  ///< for texts: the allowed ones, "sectors|vfh_plus"; empty for any
  bool live = true;          ///< a running node takes a new value; false: at its start only
};

/// The same field, read at the node's start only.
inline Field atStart(Field field) {
  field.live = false;
  return field;
}

/// One row of the list that documentation, checks and live tuning read.
struct FieldDescription {
  std::string name;
  ParamValue value;
  Field field;
};

// A params struct lists its fields once:
//
//   struct PidParams {
//     double kp = 1.0;
//     template <class Visitor>
//     void fields(Visitor&& visit) {
//       visit("kp", kp, Field{"1/s", "proportional gain", 0.0, 100.0});
//     }
//     std::string check() const;  // optional: what fields contradict each other, empty when sound
//   };
//
// A nested struct is a field too: visit("pid", pid) makes "pid/kp".

/// Every field of a params struct with its present value, in the order of its list.
template <class Params>
std::vector<FieldDescription> describe(Params params);

/// What is wrong with the values (range, choice, not finite, contradiction); empty when sound.
template <class Params>
std::string findFault(Params params);

/// Throws ConfigError when a value is out of its range; `where` names the source of the values.
template <class Params>
void validate(const Params& params, const std::string& where);

/// Takes values from a tree. Unknown keys, wrong types and bad values are ConfigErrors that name the key.
template <class Params>
void assign(const ParamTree& tree, const std::string& where, Params& params);

/// The commented YAML of a params struct: what config/*.yaml hold.
template <class Params>
std::string toYaml(Params params);

namespace params_detail {

template <class T, class = void>
struct HasFields : std::false_type {};
struct NullVisitor {
  template <class... Args>
  void operator()(Args&&...) {}
};
template <class T>
struct HasFields<T, std::void_t<decltype(std::declval<T&>().fields(std::declval<NullVisitor>()))>>
    : std::true_type {};

template <class T, class = void>
struct HasCheck : std::false_type {};
template <class T>
struct HasCheck<T, std::void_t<decltype(std::declval<const T&>().check())>> : std::true_type {};

/// Walks the list of a struct and of the structs nested in it; `leaf(path, value, field)` sees each field.
template <class Leaf>
class Walker {
 public:
  Walker(std::string prefix, Leaf& leaf) : prefix_(std::move(prefix)), leaf_(leaf) {}
  template <class T>
  void operator()(const char* name, T& value, const Field& field = {}) {
    if constexpr (HasFields<T>::value) {
      value.fields(Walker(prefix_ + name + "/", leaf_));
    } else {
      leaf_(prefix_ + name, value, field);
    }
  }

 private:
  std::string prefix_;
  Leaf& leaf_;
};

template <class Params, class Leaf>
void walk(Params& params, Leaf&& leaf) {
  params.fields(Walker<std::remove_reference_t<Leaf>>("", leaf));
}

/// Cross-field checks of a struct and of those nested in it.
class Checker {
 public:
  Checker(std::string prefix, std::string& fault) : prefix_(std::move(prefix)), fault_(fault) {}
  template <class T>
  void operator()(const char* name, T& value, const Field& = {}) {
    if constexpr (HasFields<T>::value) run(prefix_ + name + "/", value, fault_);
  }
  template <class T>
  static void run(const std::string& prefix, T& params, std::string& fault) {
    if constexpr (HasCheck<T>::value) {
      const std::string found = params.check();
      if (fault.empty() && !found.empty()) fault = prefix + found;
    }
    params.fields(Checker(prefix, fault));
  }

 private:
  std::string prefix_;
  std::string& fault_;
};

std::string faultOf(const std::string& name, const ParamValue& value, const Field& field);
/// Converts without loss (int to double); throws ConfigError naming key, wanted and found type.
void convert(const std::string& key, const ParamValue& from, const std::string& where, ParamValue& to);
void refuseUnknown(const ParamTree& tree, const std::vector<std::string>& known, const std::string& where);
std::string toYaml(const std::vector<FieldDescription>& fields);

}  // namespace params_detail

template <class Params>
std::vector<FieldDescription> describe(Params params) {
  std::vector<FieldDescription> list;
  params_detail::walk(params, [&list](const std::string& name, auto& value, const Field& field) {
    list.push_back({name, ParamValue(value), field});
  });
  return list;
}

template <class Params>
std::string findFault(Params params) {
  for (const FieldDescription& row : describe(params)) {
    std::string fault = params_detail::faultOf(row.name, row.value, row.field);
    if (!fault.empty()) return fault;
  }
  std::string fault;
  params_detail::Checker::run("", params, fault);
  return fault;
}

template <class Params>
void validate(const Params& params, const std::string& where) {
  const std::string fault = findFault(params);
  if (!fault.empty()) throw ConfigError(where + ": " + fault);
}

template <class Params>
void assign(const ParamTree& tree, const std::string& where, Params& params) {
  std::vector<std::string> known;
  params_detail::walk(params, [&](const std::string& name, auto& value, const Field&) {
    known.push_back(name);
    const auto found = tree.find(name);
    if (found == tree.end()) return;
    ParamValue converted(value);
    params_detail::convert(name, found->second, where, converted);
    value = std::get<std::remove_reference_t<decltype(value)>>(converted);
  });
  params_detail::refuseUnknown(tree, known, where);
  validate(params, where);
}

template <class Params>
std::string toYaml(Params params) {
  return params_detail::toYaml(describe(params));
}

}  // namespace frugal_nav
