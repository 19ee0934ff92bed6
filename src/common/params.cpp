#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::params_detail {
namespace {

const char* typeName(const ParamValue& value) {
  static constexpr const char* kNames[] = {
      "a truth value (true/false)", "an integer",     "a number", "a text",
      "a list of numbers",          "a list of texts"};
  return kNames[value.index()];
}

std::string numberText(double number) {
  std::ostringstream out;
  out << number;
  std::string text = out.str();
  // 3 is an integer and 2e-05 a text to a YAML 1.1 reader such as rosparam's.
  if (text.find_first_not_of("-0123456789e+") == std::string::npos) {
    text.insert(std::min(text.find('e'), text.size()), ".0");
  }
  return text;
}

std::string valueText(const ParamValue& value) {
  std::ostringstream out;
  out << std::boolalpha;
  const auto list = [&out](const auto& items, const auto& text) {
    out << '[';
    for (std::size_t i = 0; i < items.size(); ++i) out << (i == 0 ? "" : ", ") << text(items[i]);
    out << ']';
  };
  std::visit(
      [&](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, double>) {
          out << numberText(v);
        } else if constexpr (std::is_same_v<T, std::string>) {
          out << '"' << v << '"';
        } else if constexpr (std::is_same_v<T, std::vector<double>>) {
          list(v, numberText);
        } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
          list(v, [](const std::string& s) { return '"' + s + '"'; });
        } else {
          out << v;
        }
      },
      value);
  return out.str();
}

std::string rangeText(const Field& field) {
  const auto side = [](double bound) {
    std::ostringstream out;
    out << bound;
    return out.str();
  };
  return "[" + side(field.min) + ", " + side(field.max) + "]" +
         (*field.unit ? std::string(" ") + field.unit : "");
}

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

std::string numberFault(const std::string& name, double number, const Field& field) {
  if (std::isfinite(number) && number >= field.min && number <= field.max) return {};
  std::ostringstream out;
  out << name << " = " << number << " is outside " << rangeText(field);
  return out.str();
}

std::string choiceFault(const std::string& name, const std::string& text, const Field& field) {
  const std::string choices = field.choices;
  if (choices.empty() || ("|" + choices + "|").find("|" + text + "|") != std::string::npos) return {};
  return name + " = \"" + text + "\" is none of " + choices;
}

}  // namespace

std::string faultOf(const std::string& name, const ParamValue& value, const Field& field) {
  if (const int* number = std::get_if<int>(&value)) return numberFault(name, *number, field);
  if (const double* number = std::get_if<double>(&value)) return numberFault(name, *number, field);
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
    for (const double number : *numbers) {
      std::string fault = numberFault(name, number, field);
      if (!fault.empty()) return fault;
    }
  }
  if (const auto* text = std::get_if<std::string>(&value)) return choiceFault(name, *text, field);
  if (const auto* texts = std::get_if<std::vector<std::string>>(&value)) {
    for (const std::string& text : *texts) {
      std::string fault = choiceFault(name, text, field);
      if (!fault.empty()) return fault;
    }
  }
  return {};
}

void convert(const std::string& key, const ParamValue& from, const std::string& where, ParamValue& to) {
  if (from.index() == to.index()) {
    to = from;
    return;
  }
  const int* integer = std::get_if<int>(&from);
  if (integer != nullptr && std::holds_alternative<double>(to)) {
    to = static_cast<double>(*integer);
    return;
  }
  const auto* numbers = std::get_if<std::vector<double>>(&from);
  if (numbers != nullptr && numbers->empty() && std::holds_alternative<std::vector<std::string>>(to)) {
    to = std::vector<std::string>();  // an empty list does not tell what it would hold
    return;
  }
  throw ConfigError(where + ": parameter \"" + key + "\" must be " + typeName(to) + ", but it is " +
                    typeName(from) + " (" + valueText(from) + ")");
}

void refuseUnknown(const ParamTree& tree, const std::vector<std::string>& known, const std::string& where) {
  for (const auto& [key, value] : tree) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const auto nearest = std::min_element(
        known.begin(), known.end(),
        [&key = key](const auto& a, const auto& b) { return editDistance(key, a) < editDistance(key, b); });
    std::string message = where + ": unknown parameter \"" + key + "\"";
    if (nearest != known.end()) message += "; did you mean \"" + *nearest + "\"?";
    throw ConfigError(message);
  }
}

std::string toYaml(const std::vector<FieldDescription>& fields) {
  std::ostringstream out;
  std::vector<std::string> open;  // the groups whose keys are being written
  for (const FieldDescription& row : fields) {
    std::vector<std::string> path;
    std::istringstream parts(row.name);
    for (std::string part; std::getline(parts, part, '/');) path.push_back(part);
    const std::vector<std::string> groups(path.begin(), path.end() - 1);
    std::size_t shared = 0;
    while (shared < std::min(open.size(), groups.size()) && open[shared] == groups[shared]) ++shared;
    for (std::size_t i = shared; i < groups.size(); ++i) out << std::string(2 * i, ' ') << groups[i] << ":\n";
    open = groups;
    out << std::string(2 * groups.size(), ' ') << path.back() << ": " << valueText(row.value) << "  # ";
    if (*row.field.unit) out << '[' << row.field.unit << "] ";
    out << row.field.reason;
    if (*row.field.choices) out << "; one of " << row.field.choices;
    const bool is_number = !std::holds_alternative<bool>(row.value) &&
                           !std::holds_alternative<std::string>(row.value) &&
                           !std::holds_alternative<std::vector<std::string>>(row.value);
    if (is_number && (std::isfinite(row.field.min) || std::isfinite(row.field.max))) {
      out << "; from " << row.field.min << " to " << row.field.max;
    }
    out << '\n';
  }
  return out.str();
}

}  // namespace frugal_nav::params_detail
