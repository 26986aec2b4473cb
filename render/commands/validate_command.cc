// validate: views against captured truth.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/evaluate/validate.h"
#include "render/commands/commands.h"
#include "render/commands/report_option.h"
#include "render/commands/view_flags.h"

namespace raywalk::render {
namespace {

struct ValidateArguments {
  std::string room{};
  ViewFlags flags{};
  std::vector<std::string> methods{};
  ValidateOptions options{};
  int viewpoints = 0;  // per side of a cell; 0: as the number of cells allows
  DeviceFlags device{};
  int threads = 0;
};

void run(const ValidateArguments& arguments) {
  set_thread_count(arguments.threads);
  use_device(arguments.device);
  view_settings(arguments.flags);
  const Room room = Room::open(arguments.room);
  const ViewSettings settings = chosen_settings(arguments.flags, {}, room).settings;
  ValidateOptions options = arguments.options;
  options.connect.viewpoints =
      arguments.viewpoints > 0 ? arguments.viewpoints : viewpoints_for(room.grid().cells.size());
  options.connect.overlap_deg = settings.options.overlap_deg;
  options.report = report_of(options.report, arguments.room, "validate");
  options.modes = view_modes(settings, arguments.methods, room);
  fmt::print("{}\n", validate(room, options));
}

}  // namespace

void add_validate(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("validate", "Measure rendered views against captured ground truth");
  auto arguments = std::make_shared<ValidateArguments>();
  add_room(command, &arguments->room);
  command
      ->add_option("--truth", arguments->options.truth,
                   "CSV table of true views: columns file,x,y,z (metres) and optionally mask "
                   "(pictures, 0 = not compared) and distance (true distance maps, for scores at "
                   "silhouettes)")
      ->required();
  add_match_exposure(command, &arguments->options.match_exposure);
  add_report(command, &arguments->options.report,
             "Directory for index.html and metrics.json, created if it is missing (default: "
             "<room>-validate)");
  command
      ->add_option("--method", arguments->methods,
                   "Methods to render (default: all that the room supports)")
      ->delimiter(',')
      ->check(one_of({kViewMethodNames.begin(), kViewMethodNames.end()}));
  command
      ->add_option("--viewpoints", arguments->viewpoints,
                   "Viewpoints per side of a cell for the connection error; 0 = 49, fewer in rooms "
                   "of more than 24 cells")
      ->check(CLI::Range(0, 250))
      ->capture_default_str();
  add_device_flags(command, "cpu", &arguments->device);
  add_threads_option(command, &arguments->threads);
  add_connection_flags(command, &arguments->flags);
  command->footer("Example:\n  raywalk-render validate room.lf --truth gt.csv --report report");
  add_resumption(command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
