#include "render/commands/web_flags.h"

#include <CLI/CLI.hpp>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/files/output_folder.h"
#include "core/room/refined_record.h"
#include "render/view/point_argument.h"

namespace raywalk::render {

std::vector<CLI::Option*> add_web_flags(CLI::App* command, WebFlags* flags) {
  WebExportOptions* options = &flags->options;
  command->add_flag(
      "--captured", flags->captured,
      "Show the photographs, also where raywalk-build-lf refine has developed the room");
  return {
      command
          ->add_option("--budget-mb", options->budget_mb,
                       "GPU memory that the page may use for the stations around the walker, MB")
          ->check(CLI::PositiveNumber)
          ->capture_default_str(),
      command
          ->add_option("--width", options->width_px,
                       "Width of the panoramas, pixels, at most (default: what the scene requires)")
          ->check(CLI::Range(64, 32768)),
      command
          ->add_option(
              "--k", flags->k_deg,
              "Largest incidence angle of the hybrid connection, degrees, 45 to 90 (default: 90)")
          ->check(CLI::Range(45.0, 90.0)),
      command->add_option("--title", options->title, "Title of the page (default: the room's name)")
          ->type_name("WORDS"),
      add_point_option(command, "--start", &flags->start,
                       "Where the walk starts, X,Z in metres (default: the middle)"),
      command->add_option(
          "--hotspots", options->hotspots,
          "JSON list of {\"x_m\", \"y_m\", \"z_m\", \"text\", \"link\"}: points in the "
          "room that the page explains; the link may be missing"),
      command->add_option("--path", options->path,
                          "CSV table of views through which the page walks smoothly: columns "
                          "name,x,z and optionally y (metres), yaw,pitch,roll (degrees)"),
      command->add_option("--truth", options->truth,
                          "CSV table of true panoramas in the cells, columns file,x,y,z (metres), "
                          "that the page compares with its views")};
}

WebExportOptions web_options(const std::filesystem::path& room, const WebFlags& flags) {
  WebExportOptions options = flags.options;
  if (options.title.empty()) options.title = without_trailing_slash(room).stem().string();
  if (flags.k_deg != 0.0) options.k_deg = flags.k_deg;
  if (flags.start.empty()) return options;
  const std::vector<double> start = parse_point(flags.start);
  if (start.size() != 2) {
    throw UsageError("--start is " + excerpt(flags.start) +
                     "; give X,Z in metres, for example 0.1,-0.25");
  }
  options.start = PlanPoint{start[0], start[1]};
  return options;
}

Room web_room(const std::filesystem::path& room, const WebFlags& flags) {
  Room captured = Room::open(room);
  if (flags.captured) return captured;
  std::optional<Room> refined = current_refined_room(captured);
  return refined ? *std::move(refined) : std::move(captured);
}

}  // namespace raywalk::render
