// export-web: the room as a folder that a browser shows.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/command_line/point_argument.h"
#include "core/files/output_path.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/commands/web_quality.h"
#include "render/view_file.h"
#include "render/web/export_web.h"

namespace raywalk::render {
namespace {

struct ExportWebArguments {
  std::string room{};
  std::string start{};
  double k_deg = 0.0;
  std::filesystem::path out{};
  bool force = false;
  WebExportOptions options{};
  int threads = 0;
};

void run(const ExportWebArguments& arguments) {
  set_thread_count(arguments.threads);
  WebExportOptions options = arguments.options;
  if (!arguments.start.empty()) options.start = viewpoint_from_text(arguments.start);
  if (arguments.k_deg != 0.0) options.k_deg = arguments.k_deg;
  options.measure_quality = measure_web_quality;
  std::filesystem::path out = arguments.out;
  if (out.empty()) out = without_trailing_slash(arguments.room).stem().string() + "-web";
  fmt::print("{}\n", export_web(Room::open(arguments.room), options, out, arguments.force));
}

}  // namespace

void add_export_web(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "export-web", "Write the room as a folder that a browser shows from any static host");
  auto arguments = std::make_shared<ExportWebArguments>();
  WebExportOptions* options = &arguments->options;
  add_room(command, &arguments->room);
  command->add_option("-o,--out", arguments->out, "Folder to write (default: <room>-web)");
  add_force_flag(command, &arguments->force, "Replace an earlier export at --out");
  command
      ->add_option("--budget-mb", options->budget_mb,
                   "GPU memory that the page may use for the stations around the walker, MB")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--width", options->width_px,
                   "Width of the panoramas, pixels, at most (default: what the scene requires)")
      ->check(CLI::Range(64, 32768));
  command
      ->add_option("--k", arguments->k_deg,
                   "Largest incidence angle of the hybrid connection, degrees, 45 to 90 (default: "
                   "the one that connect-error measured to be best on the room, else 90)")
      ->check(CLI::Range(45.0, 90.0));
  command->add_option("--title", options->title, "Title of the page (default: the room's name)");
  add_point_option(command, "--start", &arguments->start,
                   "Where the walk starts, X,Z in metres (default: the middle)");
  command->add_option("--hotspots", options->hotspots,
                      "JSON list of {\"x_m\", \"y_m\", \"z_m\", \"text\", \"link\"}: points in the "
                      "room that the page explains; the link may be missing");
  command->add_option("--path", options->path,
                      "CSV table of views that the page plays: columns name,x,z (metres) and "
                      "optionally yaw,pitch,roll (degrees)");
  command->add_option("--truth", options->truth,
                      "CSV table of true panoramas in the cells, columns file,x,y,z (metres), that "
                      "the page compares with its views");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-render export-web room.lf --out room-web\n"
      "  raywalk-render export-web room.lf --budget-mb 128 --start 0,0.25 --path walk.csv --out "
      "room-web\n"
      "raywalk-build-lf require, run before, lets the export leave out stations that the scene "
      "does not need.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
