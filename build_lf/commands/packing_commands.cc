// Commands that make rooms: all, pack, repack, refine.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "build_lf/commands/commands.h"
#include "build_lf/pack/derived_room.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/refine/make_room.h"
#include "build_lf/refine/refine_room.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/files/words.h"
#include "core/room/refined_record.h"

namespace raywalk::build_lf {
namespace {

// Of a command whose options are `Options`.
template <typename Options>
struct Arguments {
  Options options{};
  std::string compress = "none";
  std::optional<WorkPart> part{};
  int threads = 0;
};

std::optional<WorkPart> parse_part(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::optional<int> index = parse_whole_number(text.substr(0, slash));
  const std::optional<int> count = parse_whole_number(text.substr(slash + 1));
  if (!index || !count || *index < 1 || *index > *count || *count > kMostParts) {
    return std::nullopt;
  }
  return WorkPart{*index, *count};
}

CLI::Option* add_compress_option(CLI::App* command, std::string* name) {
  return command
      ->add_option(
          "--compress", *name,
          "How panoramas are stored: none (mapped), lossless (about a third of the size), or "
          "jpeg:Q with a quality Q of 1 to 100 (94: about an eighth, hard to tell from none)")
      ->type_name("none|lossless|jpeg:Q")
      ->capture_default_str();
}

// Of the folder of a capture, too, as for raywalk-calibrate; its list is rarely calibrated.
std::filesystem::path list_in(const std::filesystem::path& folder) {
  const auto calibrated = folder / "calibration" / "poses.csv";
  if (std::filesystem::exists(calibrated)) {
    spdlog::warn("{}: its positions are taken as listed; for the calibrated ones give --frames {}",
                 folder.string(), shell_word(calibrated.string()));
  } else if (!std::filesystem::exists(folder / "rectify.json") &&
             !std::filesystem::exists(folder / "import.json")) {
    spdlog::warn(
        "{}: its positions are taken as listed; if they were measured by hand, run "
        "raywalk-calibrate all {} first",
        folder.string(), shell_word(folder.string()));
  }
  return folder / "poses.csv";
}

// What `all` and `pack` have in common.
void add_frames_options(CLI::App* command, Arguments<PackOptions>* arguments) {
  PackOptions* options = &arguments->options;
  command
      ->add_option("--frames", options->frames,
                   "Frame list: file,x,y,z[,yaw,pitch,roll][,mask][,line] in metres and degrees; "
                   "files relative to the list; - is standard input")
      ->required();
  command->add_option("-o,--out", options->out,
                      "Room directory to create (default: named after the folder of the frame "
                      "list, <folder>.lf)");
  add_force_flag(command, &options->replace,
                 "Replace the room in --out once the new one is complete");
  add_compress_option(command, &arguments->compress);
  add_line_tolerance_options(command, &options->tolerance);
  add_threads_option(command, &arguments->threads);
}

PackOptions given_options(const Arguments<PackOptions>& arguments) {
  PackOptions options = arguments.options;
  if (std::filesystem::is_directory(options.frames)) options.frames = list_in(options.frames);
  options.form = ray_form_from_name(arguments.compress);
  set_thread_count(arguments.threads);
  if (options.out.empty()) options.out = default_room_name(options.frames);
  return options;
}

void print_summary(const std::filesystem::path& room) {
  fmt::print("{}\n", summary_of(info_of(Room::open(room)), escaped(room.string())));
}

}  // namespace

void add_part_option(CLI::App* app, std::optional<WorkPart>* part, const std::string& pieces) {
  app->add_option_function<std::string>(
         "--part", [part](const std::string& text) { *part = parse_part(text); },
         fmt::format("Do only part I of N of the {}, on any machine that sees the files; the "
                     "command without it finishes",
                     pieces))
      ->type_name("I/N")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return parse_part(text)
                       ? std::string()
                       : fmt::format("{} is not I/N with 1 <= I <= N <= {}", text, kMostParts);
          },
          ""));
}

void add_all(CLI::App* app) {
  auto arguments = std::make_shared<Arguments<PackOptions>>();
  CLI::App* command =
      app->add_subcommand("all", "Pack, estimate distances and refine: a room for views");
  add_frames_options(command, arguments.get());
  command->footer(
      "Example:\n  raywalk-build-lf all --frames hall/calibration/poses.csv\n"
      "Makes hall.lf, from it hall-refined.lf, and prints the command of a view.");
  add_resumption(command);
  command->callback([arguments] { fmt::print("{}\n", make_room(given_options(*arguments))); });
}

void add_pack(CLI::App* app) {
  auto arguments = std::make_shared<Arguments<PackOptions>>();
  CLI::App* command = app->add_subcommand("pack", "Pack captured panoramas into a room");
  add_frames_options(command, arguments.get());
  command->add_option(
      "--distance", arguments->options.distances,
      "Directory of distance maps: <frame's stem>.png, 16-bit millimetres, 0 = no surface");
  add_part_option(command, &arguments->part, "lines");
  command->footer(
      "Example:\n  raywalk-build-lf pack --frames poses.csv --distance dist --out room.lf\n"
      "In parts, each on any machine, and finished:\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf --part 1/2\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf --part 2/2\n"
      "  raywalk-build-lf pack --frames poses.csv --out room.lf");
  add_resumption(command);
  command->callback([arguments] {
    const PackOptions options = given_options(*arguments);
    if (arguments->part) {
      fmt::print("{}\n", escaped(pack_part(options, *arguments->part)));
      return;
    }
    pack_room(options);
    print_summary(options.out);
  });
}

void add_repack(CLI::App* app) {
  auto arguments = std::make_shared<Arguments<RepackOptions>>();
  RepackOptions* options = &arguments->options;
  CLI::App* command =
      app->add_subcommand("repack", "Store the panoramas of a room in another form");
  command->add_option("room", options->room, "Room directory")->required();
  add_compress_option(command, &arguments->compress)->required();
  command->add_option("-o,--out", options->out,
                      "Room directory to create (default: beside the room, <room>-<form>)");
  add_force_flag(command, &options->replace,
                 "Replace the room in --out once the new one is complete");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Example:\n  raywalk-build-lf repack room.lf --compress jpeg:95 --out small.lf\n"
      "JPEG is made from what is stored: from JPEG it loses once more. What was measured of views\n"
      "is left out.");
  add_resumption(command);
  command->callback([arguments, options] {
    options->form = ray_form_from_name(arguments->compress);
    set_thread_count(arguments->threads);
    if (options->out.empty()) options->out = default_repacked_name(options->room, options->form);
    repack_room(*options);
    print_summary(options->out);
  });
}

void add_refine(CLI::App* app) {
  auto arguments = std::make_shared<Arguments<RefineOptions>>();
  RefineOptions* options = &arguments->options;
  CLI::App* command = app->add_subcommand(
      "refine", "Develop a room into few stations, each better than any photograph");
  command->add_option("room", options->room, "Room directory with distances")->required();
  command->add_option("-o,--out", options->out,
                      "Room directory to create (default: beside the room, <room>-refined)");
  add_force_flag(command, &options->replace,
                 "Replace the room in --out once the new one is complete");
  command->add_option("--stations", options->stations,
                      "About how many stations to develop; 0 = those with a distance map");
  command->add_option("--width", options->width,
                      "Width of the developed pictures in pixels, up to twice that of the captured "
                      "ones; 0 = twice, at most 8192");
  command->add_option(
      "--hold-out", options->hold_out,
      "Leave out one of every n captured stations, to evaluate views by them; 0 = use "
      "all");
  add_compress_option(command, &arguments->compress);
  add_part_option(command, &arguments->part, "stations");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-build-lf refine hall.lf\n"
      "  raywalk-build-lf refine hall.lf --stations 24 --compress jpeg:95 --out small.lf\n"
      "The result is a room like any other.");
  add_resumption(command);
  command->callback([arguments, options] {
    options->form = ray_form_from_name(arguments->compress);
    set_thread_count(arguments->threads);
    if (options->out.empty()) options->out = refined_room_path(options->room);
    if (arguments->part) {
      fmt::print("{}\n", escaped(refine_part(*options, *arguments->part)));
      return;
    }
    refine_room(*options);
    print_summary(options->out);
  });
}

}  // namespace raywalk::build_lf
