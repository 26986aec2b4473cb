// path: many views, one picture each.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/view_path.h"

namespace raywalk::render {
namespace {

struct PathArguments {
  std::string room{};
  std::filesystem::path path{};
  std::filesystem::path out{};
  bool force = false;
  ViewFrame frame{};
  ViewFlags flags{};
  Demand demand{};
  int threads = 0;
};

void run(const PathArguments& arguments) {
  set_thread_count(arguments.threads);
  viewport_of(arguments.frame);
  view_settings(arguments.flags);
  require_demand(arguments.demand);
  const std::filesystem::path out = arguments.out.empty() ? arguments.path.stem() : arguments.out;
  const Room room = Room::open(arguments.room);
  const ViewMode mode = chosen_mode(arguments.flags, arguments.demand, room);
  fmt::print("{}\n", escaped(write_path(room, mode, arguments.frame, arguments.path, out,
                                        arguments.force)));
}

}  // namespace

void add_path(CLI::App* app) {
  CLI::App* command = app->add_subcommand("path", "Render many views, one picture each");
  auto arguments = std::make_shared<PathArguments>();
  add_room(command, &arguments->room);
  command
      ->add_option("path", arguments->path,
                   "CSV table of views: columns name,x,z (metres) and optionally y (metres) and "
                   "yaw,pitch,roll "
                   "(degrees)")
      ->required();
  command->add_option(
      "-o,--out", arguments->out,
      "Directory for <name>.png, created if it is missing (default: the table's name "
      "without .csv)");
  add_force_flag(command, &arguments->force,
                 "Replace the views in --out, which were rendered with other settings");
  add_view_flags(command, &arguments->flags);
  add_demand_flags(command, &arguments->demand);
  add_flat_flags(command, &arguments->frame);
  add_stereo_flags(command, &arguments->frame);
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-render path room.lf path.csv --generation two-sided --out views\n"
      "  raywalk-render path room.lf path.csv --stereo ods --out stereo\n"
      "An interrupted run is resumed by the same command.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
