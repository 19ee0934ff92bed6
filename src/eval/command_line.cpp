#include <algorithm>
#include <sstream>

#include <frugal_nav/eval/command_line.hpp>

namespace frugal_nav::eval {
namespace {

const std::vector<std::string> kRunOptions = {"seed",    "trials",       "out",   "shard",
                                              "threads", "trajectories", "share", "help"};

/// The number a whole text spells; nullopt for anything else.
template <class Number>
std::optional<Number> parseNumber(const std::string& text) {
  std::istringstream stream(text);
  Number number{};
  stream >> number;
  if (stream.fail() || !stream.eof()) return std::nullopt;
  return number;
}

template <class Number>
Number requireNumber(const std::string& option, const std::string& text, Number least) {
  const std::optional<Number> number = parseNumber<Number>(text);
  if (!number || *number < least || text.find('-') != std::string::npos) {
    throw ConfigError("--" + option + " takes a whole number from " + std::to_string(least) + ", not '" +
                      text + "'");
  }
  return *number;
}

Shard parseShard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto index = parseNumber<int>(text.substr(0, slash));
  const auto count = slash == std::string::npos ? std::nullopt : parseNumber<int>(text.substr(slash + 1));
  if (!index || !count || *count < 1 || *index < 0 || *index >= *count)
    throw ConfigError("--shard takes i/n with 0 <= i < n, not '" + text + "'");
  return {*index, *count};
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

/// An option's text as a value of the type its description holds.
ParamValue parseValue(const FieldDescription& option, const std::string& text) {
  const auto refuse = [&](const char* wanted) {
    return ConfigError("--" + option.name + " takes " + wanted + ", not '" + text + "'");
  };
  if (std::holds_alternative<bool>(option.value)) {
    if (text != "true" && text != "false") throw refuse("true or false");
    return text == "true";
  }
  if (std::holds_alternative<int>(option.value)) {
    const auto number = parseNumber<int>(text);
    if (!number) throw refuse("a whole number");
    return *number;
  }
  if (std::holds_alternative<double>(option.value)) {
    const auto number = parseNumber<double>(text);
    if (!number) throw refuse("a number");
    return *number;
  }
  if (std::holds_alternative<std::vector<std::string>>(option.value)) return splitAtCommas(text);
  if (std::holds_alternative<std::vector<double>>(option.value)) {
    std::vector<double> numbers;
    for (const std::string& part : splitAtCommas(text)) {
      const auto number = parseNumber<double>(part);
      if (!number) throw refuse("numbers parted by commas");
      numbers.push_back(*number);
    }
    return numbers;
  }
  return text;
}

/// Walks over the arguments: positional ones, "--name value", "--name=value".
class Arguments {
 public:
  explicit Arguments(const std::vector<std::string>& all) : all_(all) {}
  bool done() const { return at_ >= all_.size(); }
  bool atOption() const { return all_[at_].rfind("--", 0) == 0; }
  std::string positional() { return all_[at_++]; }
  std::string option() {
    const std::string text = all_[at_++].substr(2);
    const std::size_t equals = text.find('=');
    value_.reset();
    if (equals != std::string::npos) value_ = text.substr(equals + 1);
    return text.substr(0, equals);
  }
  std::string value(const std::string& option) {
    if (value_) return *value_;
    if (done() || atOption()) throw ConfigError("--" + option + " lacks its value");
    return all_[at_++];
  }
  /// A switch stands for "true" unless a value follows after '='.
  std::string switchValue() const { return value_.value_or("true"); }

 private:
  const std::vector<std::string>& all_;
  std::size_t at_ = 0;
  std::optional<std::string> value_;
};

void takeSuiteOption(const std::string& given, Arguments& arguments, EvaluateCommand& command) {
  const std::unique_ptr<Suite> suite = makeSuite(command.request.suite);
  std::string name = given;  // written with dashes or, as in the files, with underscores
  std::replace(name.begin(), name.end(), '-', '_');
  std::vector<std::string> known = kRunOptions;
  for (const FieldDescription& option : suite->options()) {
    if (option.name == name) {
      const bool is_switch = std::holds_alternative<bool>(option.value);
      command.request.options[name] =
          parseValue(option, is_switch ? arguments.switchValue() : arguments.value(name));
      return;
    }
    known.push_back(option.name);
  }
  const std::string nearest = nearestName(name, known);
  throw ConfigError("the suite " + command.request.suite + " has no option --" + name +
                    (nearest.empty() ? "; --help names them" : "; did you mean --" + nearest + "?"));
}

void takeRunOption(const std::string& name, Arguments& arguments, EvaluateCommand& command) {
  RunRequest& request = command.request;
  if (name == "seed") {
    request.context.seed = requireNumber<std::uint64_t>(name, arguments.value(name), 0);
  } else if (name == "trials") {
    request.trials = requireNumber<int>(name, arguments.value(name), 1);
  } else if (name == "threads") {
    request.threads = requireNumber<int>(name, arguments.value(name), 1);
  } else if (name == "shard") {
    request.shard = parseShard(arguments.value(name));
  } else if (name == "out") {
    command.out = arguments.value(name);
  } else if (name == "share") {
    request.context.share_dir = arguments.value(name);
  } else if (name == "trajectories") {
    command.trajectories = arguments.switchValue() == "true";
  } else if (name == "help") {
    command.action = EvaluateCommand::Action::kHelp;
  } else {
    takeSuiteOption(name, arguments, command);
  }
}

EvaluateCommand parseMerge(const std::vector<std::string>& arguments) {
  EvaluateCommand command;
  command.action = EvaluateCommand::Action::kMerge;
  if (arguments.size() < 3) throw ConfigError("--merge takes OUT and the files to join");
  command.out = arguments[1];
  command.sources.assign(arguments.begin() + 2, arguments.end());
  return command;
}

}  // namespace

EvaluateCommand parseCommandLine(const std::vector<std::string>& arguments) {
  EvaluateCommand command;
  if (arguments.empty()) return command;
  if (arguments[0] == "--merge") return parseMerge(arguments);
  if (arguments[0] == "--help" || arguments[0] == "-h") return command;
  if (arguments[0] == "--list") {
    command.action = EvaluateCommand::Action::kList;
    return command;
  }
  if (arguments[0].rfind("-", 0) == 0) {
    const std::string nearest = nearestName(arguments[0], {"--merge", "--list", "--help"});
    throw ConfigError("the first argument is a suite's name, --list, --merge or --help, not '" +
                      arguments[0] + "'" + (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }
  command.action = EvaluateCommand::Action::kRun;
  command.request.suite = arguments[0];
  makeSuite(command.request.suite);
  const std::vector<std::string> rest(arguments.begin() + 1, arguments.end());
  for (Arguments left(rest); !left.done();) {
    if (!left.atOption())
      throw ConfigError("what is '" + left.positional() + "' for? --help tells the usage");
    const std::string name = left.option();
    takeRunOption(name, left, command);
  }
  return command;
}

std::string listText() {
  std::size_t width = 0;
  for (const auto& entry : suites()) width = std::max(width, entry.first.size());
  std::ostringstream text;
  for (const auto& [name, make] : suites())
    text << "  " << name << std::string(width - name.size() + 2, ' ') << make()->help() << "\n";
  return text.str();
}

std::string helpText(const std::string& suite) {
  std::ostringstream text;
  text << "usage: evaluate SUITE [--seed S] [--trials N] [--out DIR] [--shard i/n] [--threads N]\n"
          "                      [--trajectories] [--share DIR] [suite options]\n"
          "       evaluate --merge OUT A.json B.json...\n"
          "       evaluate --list | SUITE --help\n\n"
          "  --seed S         trial k is drawn from seed S + k (default 1)\n"
          "  --trials N       number of trials (default: the suite's)\n"
          "  --out DIR        writes DIR/SUITE.json and DIR/SUITE.csv (default: results)\n"
          "  --shard i/n      runs trials i, i+n, i+2n, ... only; --merge joins the shards' files\n"
          "  --threads N      worker threads (default: one per processor); the numbers do not depend on it\n"
          "  --trajectories   writes DIR/trajectories too, for scripts/plot\n"
          "  --share DIR      the package's folder with urdf/ and config/ (default: where ROS finds it)\n\n";
  if (suite.empty()) {
    text << "suites:\n" << listText();
    return text.str();
  }
  const std::unique_ptr<Suite> made = makeSuite(suite);
  text << suite << ": " << made->help() << "\n  " << made->defaultTrials() << " trials by default\n";
  for (const FieldDescription& option : made->options()) {
    text << "  --" << option.name;
    if (*option.field.unit != '\0') text << " [" << option.field.unit << "]";
    text << "  " << option.field.reason;
    if (*option.field.choices != '\0') text << " (" << option.field.choices << ")";
    text << "\n";
  }
  return text.str();
}

}  // namespace frugal_nav::eval
