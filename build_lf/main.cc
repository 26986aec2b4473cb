// raywalk-build-lf: packs captured frames into a room, estimates distances, inspects rooms.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "build_lf/block.h"
#include "build_lf/depth/estimate_depth.h"
#include "build_lf/distance_sets.h"
#include "build_lf/export/export_room.h"
#include "build_lf/gains/make_gains.h"
#include "build_lf/pack_room.h"
#include "build_lf/refine/refine_room.h"
#include "build_lf/repack_room.h"
#include "build_lf/require/require_room.h"
#include "build_lf/room_info.h"
#include "build_lf/room_verify.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/command_line/program.h"
#include "core/files/words.h"
#include "core/room/refined_record.h"

namespace raywalk::build_lf {
namespace {

struct Arguments {
  PackOptions pack;
  RepackOptions repack{};
  std::optional<Block> block{};
  DepthOptions depth{};
  std::string depth_method = "sweep";
  RefineOptions refine{};
  RequireOptions require{};
  ExportOptions exported{};
  std::string export_format = "colmap";
  std::string step;  // of depth
  int threads = 0;
  std::string room;
  std::string compress = "none";
  bool json = false;
  std::string use;
  bool remove = false;
};

std::optional<Block> parse_block(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::optional<int> index = parse_whole_number(text.substr(0, slash));
  const std::optional<int> count = parse_whole_number(text.substr(slash + 1));
  if (!index || !count || *index < 1 || *index > *count || *count > kMostBlocks) {
    return std::nullopt;
  }
  return Block{*index, *count};
}

// `pieces` says in words what is divided.
void add_block_option(CLI::App* app, std::optional<Block>* block, const std::string& pieces) {
  app->add_option_function<std::string>(
         "--block", [block](const std::string& text) { *block = parse_block(text); },
         fmt::format("Do only block I of N of the {}, on any machine that sees the files; the "
                     "command without it finishes",
                     pieces))
      ->type_name("I/N")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return parse_block(text)
                       ? std::string()
                       : fmt::format("{} is not I/N with 1 <= I <= N <= {}", text, kMostBlocks);
          },
          ""));
}

CLI::Option* add_compress_option(CLI::App* app, std::string* name) {
  return app
      ->add_option(
          "--compress", *name,
          "How panoramas are stored: none (mapped), lossless (about a third of the size), or "
          "jpeg:Q with a quality Q of 1 to 100 (94: about an eighth, hard to tell from none)")
      ->type_name("none|lossless|jpeg:Q")
      ->capture_default_str();
}

void add_pack(CLI::App* app, Arguments* arguments) {
  CLI::App* pack = app->add_subcommand("pack", "Pack captured panoramas into a room");
  pack->add_option("--frames", arguments->pack.frames,
                   "Frame list: file,x,y,z[,yaw,pitch,roll][,mask][,line] in metres and degrees; "
                   "files relative to "
                   "the list; - is standard input")
      ->required();
  pack->add_option("-o,--out", arguments->pack.out,
                   "Room directory to create (default: named after the folder of the frame list, "
                   "<folder>.lf)");
  pack->add_option(
      "--distance", arguments->pack.distances,
      "Directory of distance maps: <frame's stem>.png, 16-bit millimetres, 0 = no surface");
  add_force_flag(pack, &arguments->pack.replace,
                 "Replace the room in --out once the new one is complete");
  add_compress_option(pack, &arguments->compress);
  add_line_tolerance_options(pack, &arguments->pack.tolerance);
  add_block_option(pack, &arguments->block, "lines");
  add_threads_option(pack, &arguments->threads);
  pack->footer(
      "Example:\n  raywalk-build-lf pack --frames poses.csv --distance dist --out room.lf\n"
      "The same command resumes a stopped run.\n"
      "In blocks, each on any machine, and finished:\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf --block 1/2\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf --block 2/2\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf");
  pack->callback([arguments] {
    arguments->pack.form = ray_form_from_name(arguments->compress);
    set_thread_count(arguments->threads);
    if (arguments->pack.out.empty()) {
      arguments->pack.out = default_room_name(arguments->pack.frames);
    }
    if (arguments->block) {
      fmt::print("{}\n", escaped(pack_block(arguments->pack, *arguments->block)));
      return;
    }
    pack_room(arguments->pack);
    const std::string out = arguments->pack.out.string();
    fmt::print("{}\n", summary_of(info_of(Room::open(out)), escaped(out)));
  });
}

void add_repack(CLI::App* app, Arguments* arguments) {
  RepackOptions* options = &arguments->repack;
  CLI::App* repack = app->add_subcommand("repack", "Store the panoramas of a room in another form");
  repack->add_option("room", options->room, "Room directory")->required();
  add_compress_option(repack, &arguments->compress)->required();
  repack->add_option("-o,--out", options->out,
                     "Room directory to create (default: beside the room, <room>-<form>)");
  add_force_flag(repack, &options->replace,
                 "Replace the room in --out once the new one is complete");
  add_threads_option(repack, &arguments->threads);
  repack->footer(
      "Example:\n  raywalk-build-lf repack room.lf --compress jpeg:95 --out small.lf\n"
      "JPEG is made from what is stored: from JPEG it loses once more. What was measured of views\n"
      "is left out. The same command resumes a stopped run.");
  repack->callback([arguments, options] {
    options->form = ray_form_from_name(arguments->compress);
    set_thread_count(arguments->threads);
    if (options->out.empty()) options->out = default_repacked_name(options->room, options->form);
    repack_room(*options);
    const std::string out = options->out.string();
    fmt::print("{}\n", summary_of(info_of(Room::open(out)), escaped(out)));
  });
}

void add_depth(CLI::App* app, Arguments* arguments) {
  DepthOptions* options = &arguments->depth;
  CLI::App* depth = app->add_subcommand("depth", "Estimate distances from the captured panoramas");
  depth->add_option("room", options->room, "Room directory")->required();
  depth
      ->add_option("--method", arguments->depth_method,
                   "sweep: many stations of all lines (default); flow: optical flow along a line")
      ->type_name("sweep|flow");
  depth->add_option("--every", options->every,
                    "A map at every n-th station; 0 = chosen from the cell size");
  depth->add_option("--width", options->width,
                    "Width of the maps in pixels; 0 = as captured, at most 1024");
  depth->add_option("--valid-mask", options->valid_mask,
                    "Mask for all panoramas, a grey image in world axes; black pixels are ignored");
  depth->add_option("--hold-out", options->hold_out,
                    "Leave out one of every n stations and write the maps to room.lf/held-out, for "
                    "raywalk-render trade --held-out; 0 = use all");
  depth->add_flag_callback(
      "--keep-moving", [options] { options->leave_out_moving = false; },
      "Also use what single stations show and the others contradict: people and cars that moved");
  depth->add_flag("--truth", options->compare_truth,
                  "Compare with the distances packed with the room");
  depth->add_flag("!--no-gains", options->gains,
                  "Leave the room's gains as they are (default: solve for them with the new "
                  "distances, as `gains` does)");
  depth
      ->add_option("--step", arguments->step,
                   "Do only this step; each needs those before it: " + depth_step_names())
      ->type_name("STEP");
  add_block_option(depth, &arguments->block, "step");
  add_threads_option(depth, &arguments->threads);
  depth->footer(
      "Examples:\n  raywalk-build-lf depth room.lf\n"
      "  raywalk-build-lf depth room.lf --step sweep --block 1/16\n"
      "The same command resumes a stopped run. Views then use the estimated distances; those\n"
      "packed with the room are kept, and `raywalk-build-lf distances` goes back to them.");
  depth->callback([arguments] {
    arguments->depth.method = depth_method_from_name(arguments->depth_method);
    set_thread_count(arguments->threads);
    if (!arguments->step.empty()) {
      const DepthStep step = depth_step_from_name(arguments->step);
      fmt::print("{}\n", escaped(estimate_step(arguments->depth, step,
                                               arguments->block.value_or(Block{}))));
      return;
    }
    if (arguments->block) throw UsageError("--block: give --step too: " + depth_step_names());
    fmt::print("{}", text_of(estimate_depth(arguments->depth)));
  });
}

void add_refine(CLI::App* app, Arguments* arguments) {
  RefineOptions* options = &arguments->refine;
  CLI::App* refine = app->add_subcommand(
      "refine", "Develop a room into few stations, each better than any photograph");
  refine->add_option("room", options->room, "Room directory with distances")->required();
  refine->add_option("-o,--out", options->out,
                     "Room directory to create (default: beside the room, <room>-refined)");
  add_force_flag(refine, &options->replace,
                 "Replace the room in --out once the new one is complete");
  refine->add_option("--stations", options->stations,
                     "About how many stations to develop; 0 = those with a distance map");
  refine->add_option("--width", options->width,
                     "Width of the developed pictures in pixels, up to twice that of the captured "
                     "ones; 0 = twice, at most 8192");
  refine->add_option("--hold-out", options->hold_out,
                     "Leave out one of every n captured stations, to judge views by them; 0 = use "
                     "all");
  add_compress_option(refine, &arguments->compress);
  add_threads_option(refine, &arguments->threads);
  refine->footer(
      "Examples:\n  raywalk-build-lf refine hall.lf\n"
      "  raywalk-build-lf refine hall.lf --stations 24 --compress jpeg:95 --out small.lf\n"
      "The result is a room like any other. The same command resumes a stopped run.");
  refine->callback([arguments, options] {
    options->form = ray_form_from_name(arguments->compress);
    set_thread_count(arguments->threads);
    if (options->out.empty()) options->out = refined_room_path(options->room);
    refine_room(*options);
    const std::string out = options->out.string();
    fmt::print("{}\n", summary_of(info_of(Room::open(out)), escaped(out)));
  });
}

void add_gains(CLI::App* app, Arguments* arguments) {
  CLI::App* gains = app->add_subcommand(
      "gains", "Make the exposures of a room's panoramas agree in views, also locally");
  gains->add_option("room", arguments->room, "Room directory")->required();
  gains->add_flag("--remove", arguments->remove, "Remove the room's gains instead");
  add_threads_option(gains, &arguments->threads);
  gains->footer(
      "Example:\n  raywalk-build-lf gains room.lf\n"
      "The gains are solved from surfaces that several stations see, so the room needs distances;\n"
      "`depth` does the same at its end. Panoramas are not changed: views multiply what they "
      "read,\n"
      "unless they are rendered with --no-gains.");
  gains->callback([arguments] {
    set_thread_count(arguments->threads);
    if (!arguments->remove) {
      const std::string text = text_of(make_gains(arguments->room));
      fmt::print("{}\n", escaped(arguments->room + ": " + text));
      return;
    }
    const bool removed = remove_gains(arguments->room);
    fmt::print("{}\n",
               escaped(arguments->room + (removed ? ": the gains are removed" : ": has no gains")));
  });
}

void add_distances(CLI::App* app, Arguments* arguments) {
  CLI::App* distances = app->add_subcommand(
      "distances", "Show which distances views use, and switch between given and estimated ones");
  distances->add_option("room", arguments->room, "Room directory")->required();
  CLI::Option* use =
      distances
          ->add_option("--use", arguments->use,
                       "Let views use these: given (packed with the room) or estimated (by depth)")
          ->type_name("given|estimated");
  distances->footer(
      "Examples:\n  raywalk-build-lf distances room.lf\n"
      "  raywalk-build-lf distances room.lf --use given");
  distances->callback([arguments, use] {
    if (*use) {
      fmt::print("{}\n", use_distances(arguments->room, distance_kind_from_name(arguments->use)));
    } else {
      fmt::print("{}", distances_text(arguments->room));
    }
  });
}

void add_info(CLI::App* app, Arguments* arguments) {
  CLI::App* info = app->add_subcommand("info", "Show lines, cells, spacing, sizes and coverage");
  info->add_option("room", arguments->room, "Room directory")->required();
  info->add_flag("--json", arguments->json, "Print JSON");
  info->footer("Example:\n  raywalk-build-lf info room.lf");
  info->callback([arguments] {
    const RoomInfo room = info_of(Room::open(arguments->room));
    fmt::print("{}", arguments->json ? json_of(room) : text_of(room, escaped(arguments->room)));
  });
}

void add_verify(CLI::App* app, Arguments* arguments) {
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

void add_require(CLI::App* app, Arguments* arguments) {
  RequireOptions* options = &arguments->require;
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

void add_export(CLI::App* app, Arguments* arguments) {
  ExportOptions* options = &arguments->exported;
  CLI::App* command = app->add_subcommand(
      "export", "Export a room for other reconstruction and measuring programs");
  command->add_option("room", options->room, "Room directory")->required();
  command
      ->add_option("--format", arguments->export_format,
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
    options->format = export_format_from_name(arguments->export_format);
    set_thread_count(arguments->threads);
    fmt::print("{}\n", escaped(export_room(*options)));
  });
}

}  // namespace
}  // namespace raywalk::build_lf

int main(int argc, char** argv) {
  CLI::App app("Packs 360-degree captures of a grid into light-field volumes", "raywalk-build-lf");
  app.set_version_flag("--version", std::string("raywalk-build-lf " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer("Example:\n  raywalk-build-lf pack --frames poses.csv --out room.lf");
  raywalk::build_lf::Arguments arguments;
  raywalk::build_lf::add_pack(&app, &arguments);
  raywalk::build_lf::add_repack(&app, &arguments);
  raywalk::build_lf::add_depth(&app, &arguments);
  raywalk::build_lf::add_refine(&app, &arguments);
  raywalk::build_lf::add_distances(&app, &arguments);
  raywalk::build_lf::add_gains(&app, &arguments);
  raywalk::build_lf::add_info(&app, &arguments);
  raywalk::build_lf::add_verify(&app, &arguments);
  raywalk::build_lf::add_require(&app, &arguments);
  raywalk::build_lf::add_export(&app, &arguments);
  return raywalk::run_program(app, argc, argv);
}
