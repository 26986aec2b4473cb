// export-web: the room as a folder that a browser shows.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/files/output_folder.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/commands/web_flags.h"
#include "render/commands/web_quality.h"
#include "render/web/export_web.h"

namespace raywalk::render {
namespace {

struct ExportWebArguments {
  std::string room{};
  std::filesystem::path out{};
  bool force = false;
  WebFlags web{};
  int threads = 0;
};

void run(const ExportWebArguments& arguments) {
  set_thread_count(arguments.threads);
  WebExportOptions options = web_options(arguments.room, arguments.web);
  options.measure_quality = measure_web_quality;
  std::filesystem::path out = arguments.out;
  if (out.empty()) out = without_trailing_slash(arguments.room).stem().string() + "-web";
  const Room room = web_room(arguments.room, arguments.web);
  fmt::print("{}\nnext: put the folder on any web server, or raywalk-render serve {} --export {}\n",
             export_web(room, options, out, arguments.force), escaped(shell_word(arguments.room)),
             escaped(shell_word(out.string())));
}

}  // namespace

void add_export_web(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "export-web", "Write the room as a folder that a browser shows from any static host");
  auto arguments = std::make_shared<ExportWebArguments>();
  add_room(command, &arguments->room);
  command->add_option("-o,--out", arguments->out, "Folder to write (default: <room>-web)");
  add_force_flag(command, &arguments->force, "Replace an earlier export at --out");
  add_web_flags(command, &arguments->web);
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-render export-web room.lf --out room-web\n"
      "  raywalk-render export-web room.lf --budget-mb 128 --start 0,0.25 --path walk.csv --out "
      "room-web\n"
      "Where raywalk-build-lf refine has made room-refined.lf, that is shown. raywalk-build-lf "
      "require, run before, lets the export leave out stations that the scene does not need.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
