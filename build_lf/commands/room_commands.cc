// Commands that show, check, measure and export a room.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "build_lf/commands/commands.h"
#include "build_lf/export/export_room.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "build_lf/require/require_room.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"

namespace raywalk::build_lf {
namespace {

struct RoomArguments {
  std::string room{};
  bool json = false;
  int threads = 0;
};

struct RequireArguments {
  RequireOptions options{};
  int threads = 0;
};

struct ExportArguments {
  ExportOptions options{};
  std::string format = "colmap";
  int threads = 0;
};

}  // namespace

void add_info(CLI::App* app) {
  auto arguments = std::make_shared<RoomArguments>();
  CLI::App* info = app->add_subcommand("info", "Show lines, cells, spacing, sizes and coverage");
  info->add_option("room", arguments->room, "Room directory")->required();
  info->add_flag("--json", arguments->json, "Print JSON");
  info->footer("Example:\n  raywalk-build-lf info room.lf");
  info->callback([arguments] {
    const RoomInfo room = info_of(Room::open(arguments->room));
    fmt::print("{}", arguments->json ? json_of(room) : text_of(room, escaped(arguments->room)));
  });
}

void add_verify(CLI::App* app) {
  auto arguments = std::make_shared<RoomArguments>();
  CLI::App* verify = app->add_subcommand("verify", "Check a room against its stored checksums");
  verify->add_option("room", arguments->room, "Room directory")->required();
  add_threads_option(verify, &arguments->threads);
  verify->footer("Example:\n  raywalk-build-lf verify room.lf");
  verify->callback([arguments] {
    set_thread_count(arguments->threads);
    const Room room = Room::open(arguments->room);
    fmt::print("{}\n", escaped(text_of(verify_room(room), room)));
  });
}

void add_require(CLI::App* app) {
  auto arguments = std::make_shared<RequireArguments>();
  RequireOptions* options = &arguments->options;
  CLI::App* command = app->add_subcommand(
      "require", "Measure what the scene requires: layers, spacing, k, widths and bytes");
  command->add_option("room", options->room, "Room directory with distances")->required();
  command
      ->add_option("--tolerance-px", options->tolerance_px,
                   "Tolerated displacement of a pixel, at the panoramas' width")
      ->capture_default_str();
  command->add_option("--thin", options->thin,
                      "Write a room with only the needed stations, and measure the loss");
  add_force_flag(command, &options->replace_thin, "Replace the room in --thin");
  command->add_option("-o,--report,--out", options->report,
                      "Directory for index.html and require.json, created if missing");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-build-lf require room.lf --report report\n"
      "The result is kept in the room; raywalk-render --preset fast and export-web use it.");
  command->callback([arguments, options] {
    set_thread_count(arguments->threads);
    fmt::print("{}\n", require_room(*options));
  });
}

void add_export(CLI::App* app) {
  auto arguments = std::make_shared<ExportArguments>();
  ExportOptions* options = &arguments->options;
  CLI::App* command = app->add_subcommand(
      "export", "Export a room for other reconstruction and measuring programs");
  command->add_option("room", options->room, "Room directory")->required();
  command
      ->add_option("--format", arguments->format,
                   "colmap: a model of flat faces; nerfstudio: panoramas and transforms.json; "
                   "frames: panoramas, poses.csv and distance maps; ply: points of the distances")
      ->required();
  command->add_option("-o,--out", options->out,
                      "Directory to create, or file of a ply (default: named after the room, "
                      "<room>-<format> or <room>.ply)");
  add_force_flag(command, &options->replace, "Replace an earlier export in --out");
  command->add_option("--every", options->every, "Export every n-th station of each line")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--face-px", options->face_px,
                   "Side of the flat faces of a colmap model in pixels, even; 0 = as fine as the "
                   "panoramas")
      ->check(CLI::Range(0, 16384));
  command
      ->add_option("--points", options->points,
                   "Points of a colmap model that are tried; those that two stations confirm stay")
      ->check(CLI::Range(0, 100'000'000))
      ->capture_default_str();
  command
      ->add_option("--voxel-mm", options->voxel_mm,
                   "Thin the points of ply and nerfstudio to one in each cube of this side, mm")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  command
      ->add_option("--max-distance-m", options->max_distance_m,
                   "Leave out points farther than this from their station, m; 0 = none")
      ->check(CLI::Range(0.0, 1e6));
  command->add_flag("--jpeg", options->jpeg, "Write pictures as JPEG instead of PNG");
  command->add_flag("!--no-gains", options->gains,
                    "Export pictures and colours as captured, without the room's gains");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-build-lf export hall.lf --format colmap --out hall-colmap\n"
      "  raywalk-build-lf export hall.lf --format ply --voxel-mm 5 --out hall.ply\n"
      "Points, distances and the observations of points come from the room's distances. An\n"
      "interrupted export leaves nothing behind.");
  command->callback([arguments, options] {
    options->format = export_format_from_name(arguments->format);
    set_thread_count(arguments->threads);
    fmt::print("{}\n", escaped(export_room(*options)));
  });
}

}  // namespace raywalk::build_lf
