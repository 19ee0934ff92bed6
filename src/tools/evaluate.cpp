// Runs an evaluation suite and writes its result; see `evaluate --help`.

#include <filesystem>
#include <iostream>

#include <ros/package.h>
#include <unistd.h>

#include <frugal_nav/eval/command_line.hpp>

namespace {

using frugal_nav::ConfigError;
using frugal_nav::eval::EvaluateCommand;

void drawProgress(int done, int total) {
  constexpr int kWidth = 40;
  const int filled = kWidth * done / total;
  std::cerr << "\r[" << std::string(static_cast<std::size_t>(filled), '#')
            << std::string(static_cast<std::size_t>(kWidth - filled), ' ') << "] " << done << "/" << total
            << (done == total ? "\n" : "") << std::flush;
}

std::string shareDir() {
  const std::string dir = ros::package::getPath("frugal_nav");
  if (dir.empty())
    throw ConfigError(
        "ROS does not find the package frugal_nav: source the workspace's setup.bash, or give --share");
  return dir;
}

void run(EvaluateCommand command) {
  auto& context = command.request.context;
  command.request.version = FRUGAL_NAV_VERSION;
  if (context.share_dir.empty()) context.share_dir = shareDir();
  if (command.trajectories) {
    context.trajectory_dir = (std::filesystem::path(command.out) / "trajectories").string();
    std::filesystem::create_directories(context.trajectory_dir);
  }
  context.picture_dir = (std::filesystem::path(command.out) / "failures").string();
  const auto result = frugal_nav::eval::runSuite(
      command.request, isatty(STDERR_FILENO) != 0 ? drawProgress : frugal_nav::eval::Progress{});
  std::cout << toTable(result) << "written: " << writeResult(result, command.out) << "\n";
}

void merge(const EvaluateCommand& command) {
  std::vector<frugal_nav::eval::Result> shards;
  for (const std::string& source : command.sources) shards.push_back(frugal_nav::eval::readResult(source));
  const auto result = mergeResults(shards);
  std::cout << toTable(result) << "written: " << writeResult(result, command.out) << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const EvaluateCommand command =
        frugal_nav::eval::parseCommandLine(std::vector<std::string>(argv + 1, argv + argc));
    switch (command.action) {
      case EvaluateCommand::Action::kRun:
        run(command);
        break;
      case EvaluateCommand::Action::kMerge:
        merge(command);
        break;
      case EvaluateCommand::Action::kList:
        std::cout << frugal_nav::eval::listText();
        break;
      case EvaluateCommand::Action::kHelp:
        std::cout << frugal_nav::eval::helpText(command.request.suite);
        break;
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "evaluate: " << error.what() << "\n";
    return 1;
  }
}
