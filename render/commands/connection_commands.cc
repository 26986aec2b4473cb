// connect-error and error-model: how well neighbouring lines connect.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/evaluate/connect_error.h"
#include "render/commands/commands.h"
#include "render/commands/error_model_report.h"
#include "render/commands/report_option.h"
#include "render/commands/view_flags.h"

namespace raywalk::render {
namespace {

struct ConnectErrorArguments {
  std::string room{};
  std::vector<std::string> methods{};
  ConnectErrorOptions options{};
  int threads = 0;
};

void run(const ConnectErrorArguments& arguments) {
  set_thread_count(arguments.threads);
  std::vector<ViewMethod> methods;
  for (const std::string& name : arguments.methods) {
    methods.push_back(method_from_name(name));
  }
  if (methods.empty()) methods.push_back(ViewMethod::kInitial);
  const Room room = Room::open(arguments.room);
  for (const ViewMethod method : methods) {
    std::cout << connect_error_table(measure_connect_error(room, method, arguments.options))
              << std::flush;
  }
  std::cout << "distances in use: " << room.distances_origin() << '\n';
}

}  // namespace

void add_connect_error(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("connect-error", "Measure how well neighbouring lines connect");
  auto arguments = std::make_shared<ConnectErrorArguments>();
  ConnectErrorOptions* options = &arguments->options;
  add_room(command, &arguments->room);
  command->add_option("--method", arguments->methods, "Methods to measure")
      ->delimiter(',')
      ->check(one_of({kViewMethodNames.begin(), kViewMethodNames.end()}))
      ->default_str("initial");
  command->add_option("--viewpoints", options->viewpoints, "Viewpoints per side of a cell")
      ->check(CLI::Range(1, 250))
      ->capture_default_str();
  command
      ->add_option("--overlap-deg", options->overlap_deg, "Width of the overlap, degrees, up to 45")
      ->capture_default_str();
  command->add_option("--k-list", options->k_list_deg, "Angles k to measure, degrees in 45..90")
      ->delimiter(',')
      ->capture_default_str();
  add_threads_option(command, &arguments->threads);
  command->footer("Example:\n  raywalk-render connect-error room.lf --method initial,hlf-vd");
  command->callback([arguments] { run(*arguments); });
}

void add_error_model(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("error-model", "Compute the paper's Fig. 11: errors over the angle k");
  auto options = std::make_shared<ErrorModelOptions>();
  add_report(command, &options->report_dir, "Directory for the page, created if it is missing")
      ->default_val("error-model");
  command->add_option("--side-m", options->side_m, "Side N of the cell, metres")
      ->capture_default_str();
  command->add_option("--step-m", options->step_m, "Spacing of the stations, metres")
      ->capture_default_str();
  command
      ->add_option("--d-src", options->distances_over_side,
                   "Distances of the scene in multiples of N, comma-separated")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--viewpoints", options->viewpoints, "Viewpoints per side of the cell")
      ->capture_default_str();
  command->footer(
      "Example:\n  raywalk-render error-model --step-m 0.15 --d-src 1.2,1.5,2.5 --report fig11");
  command->callback([options] { write_error_model_report(*options, std::cout); });
}

}  // namespace raywalk::render
