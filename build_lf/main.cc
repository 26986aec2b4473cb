// raywalk-build-lf: packs captured frames into a room, and looks into rooms.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "build_lf/pack_room.h"
#include "build_lf/room_info.h"
#include "build_lf/room_verify.h"
#include "core/base/parallel.h"
#include "core/base/program.h"

namespace raywalk {
namespace {

struct Arguments {
  PackOptions pack;
  double line_tolerance_mm = 0.0;
  int threads = 0;
  std::string room;
  bool json = false;
};

void add_pack(CLI::App* app, Arguments* arguments) {
  CLI::App* pack = app->add_subcommand("pack", "Pack captured panoramas into a room");
  pack->add_option(
          "--frames", arguments->pack.frames,
          "Frame list: file,x,y,z[,yaw,pitch,roll] in metres and degrees; files relative to "
          "the list")
      ->required();
  pack->add_option("--out", arguments->pack.out, "Room directory to make")->required();
  pack->add_option(
      "--distance", arguments->pack.distances,
      "Directory of distance maps: <frame's stem>.png, 16-bit millimetres, 0 = no surface");
  CLI::Option* tolerance =
      pack->add_option("--line-tolerance-mm", arguments->line_tolerance_mm,
                       "How far a station may lie off its line (default: a tenth of the spacing)")
          ->check(CLI::Range(1e-6, 1e6));
  pack->add_option("--threads", arguments->threads, "Threads to use; 0 = all cores")
      ->check(CLI::Range(0, 1024));
  pack->footer(
      "Example:\n  raywalk-build-lf pack --frames poses.csv --distance dist --out room.lf\n"
      "A run that was stopped is resumed by the same command.");
  pack->callback([arguments, tolerance] {
    if (*tolerance) arguments->pack.off_line_m = arguments->line_tolerance_mm * 1e-3;
    set_thread_count(arguments->threads);
    pack_room(arguments->pack);
    const std::string out = arguments->pack.out.string();
    fmt::print("{}\n", summary_of(info_of(Room::open(out)), out));
  });
}

void add_info(CLI::App* app, Arguments* arguments) {
  CLI::App* info = app->add_subcommand("info", "Show lines, cells, spacing, sizes and coverage");
  info->add_option("room", arguments->room, "Room directory")->required();
  info->add_flag("--json", arguments->json, "Print JSON");
  info->footer("Example:\n  raywalk-build-lf info room.lf");
  info->callback([arguments] {
    const RoomInfo room = info_of(Room::open(arguments->room));
    fmt::print("{}", arguments->json ? json_of(room) : text_of(room, arguments->room));
  });
}

void add_verify(CLI::App* app, Arguments* arguments) {
  CLI::App* verify = app->add_subcommand("verify", "Check a room against its stored checksums");
  verify->add_option("room", arguments->room, "Room directory")->required();
  verify->add_option("--threads", arguments->threads, "Threads to use; 0 = all cores")
      ->check(CLI::Range(0, 1024));
  verify->footer("Example:\n  raywalk-build-lf verify room.lf");
  verify->callback([arguments] {
    set_thread_count(arguments->threads);
    const VerifiedCounts counts = verify_room(Room::open(arguments->room));
    fmt::print("{}: {} panoramas and {} distance maps match their checksums\n", arguments->room,
               counts.panoramas, counts.distance_maps);
  });
}

}  // namespace
}  // namespace raywalk

int main(int argc, char** argv) {
  CLI::App app("Packs 360-degree captures of a grid into light-field volumes", "raywalk-build-lf");
  app.set_version_flag("--version", std::string("raywalk-build-lf " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer("Example:\n  raywalk-build-lf pack --frames poses.csv --out room.lf");
  raywalk::Arguments arguments;
  raywalk::add_pack(&app, &arguments);
  raywalk::add_info(&app, &arguments);
  raywalk::add_verify(&app, &arguments);
  return raywalk::run_program(app, argc, argv);
}
