// raywalk-render: renders views of a room, and validates them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/command_line/point_argument.h"
#include "core/command_line/program.h"
#include "core/files/output_path.h"
#include "core/judge/trade/trade.h"
#include "core/judge/validation/connect_error_file.h"
#include "core/judge/validation/error_model_report.h"
#include "core/judge/validation/validate.h"
#include "render/measured_choice.h"
#include "render/presets.h"
#include "render/view_file.h"
#include "render/view_path.h"
#include "render/view_settings.h"

namespace raywalk::render {
namespace {

struct Arguments {
  std::string room{};
  std::string at{};
  std::string out{};
  ViewFrame frame{};
  std::string path{};
  bool force = false;
  ViewFlags flags{};
  Demand demand{};
  ValidateOptions validate{};
  std::vector<std::string> generations{};
  ConnectErrorOptions connect_error{};
  ErrorModelOptions error_model{};
  TradeOptions trade{};
  int threads = 0;
};

const std::vector<std::string> kGenerations{"initial", "hlf-vd", "two-sided"};
const std::vector<std::string> kPresets{"fast", "balanced", "accurate"};
const std::vector<std::string> kConnections{"hybrid", "lfu", "rayspace360"};

// All presets for a room.
std::vector<NamedMode> preset_modes(const Room& room) {
  const SceneNumbers scene = scene_numbers(room);
  std::vector<NamedMode> modes;
  for (const std::string& name : kPresets) {
    const Preset preset = preset_of(name, scene);
    modes.push_back({name, preset.reason, view_mode(preset.settings, room)});
  }
  return modes;
}

// The settings for a room; prints the reason where a preset or a measurement chose them.
Preset chosen_settings(const ViewFlags& flags, const Demand& demand, const Room& room) {
  const bool demanded = demand.budget_ms || demand.min_psnr_db;
  Preset preset = demanded ? demanded_settings(flags, demand, room) : preset_settings(flags, room);
  if (!preset.reason.empty()) fmt::print("{}\n", preset.reason);
  return preset;
}

// The mode for a room of views that these flags ask for.
ViewMode chosen_mode(const Arguments& arguments, const Room& room) {
  const Preset chosen = chosen_settings(arguments.flags, arguments.demand, room);
  ViewMode mode = view_mode(chosen.settings, room);
  if (!chosen.k_source.empty()) mode.k_source = chosen.k_source;
  return mode;
}

// The groups of the long helps, behind the common flags.
constexpr const char* kConnectionGroup = "Connection and layers";
constexpr const char* kTradeGroup = "Speed against accuracy";
constexpr const char* kDirectionGroup = "Direction and flat pictures";

void add_room(CLI::App* command, Arguments* arguments) {
  command->add_option("room", arguments->room, "Room directory, made by raywalk-build-lf pack")
      ->required();
}

// The result of a command that writes a report: -o names it as that of other commands.
CLI::Option* add_report(CLI::App* command, std::filesystem::path* report,
                        const std::string& description) {
  return command->add_option("-o,--report,--out", *report, description);
}

// `given`, or where it is empty a directory named after the room: hall.lf becomes hall-validate.
std::filesystem::path report_of(const std::filesystem::path& given, const std::string& room,
                                const std::string& command) {
  if (!given.empty()) return given;
  return without_trailing_slash(room).stem().string() + "-" + command;
}

void add_trade_flags(CLI::App* command, ViewFlags* flags) {
  command->option_defaults()->group(kTradeGroup);
  command
      ->add_option(
          "--preset", flags->preset,
          "Defaults for the other flags, derived from the room's distances, spacing and width: "
          "fast, balanced or accurate")
      ->check(CLI::IsMember(kPresets))
      ->group("Options");
  command
      ->add_option("--interpolation", flags->interpolation,
                   "How a pixel is read from a panorama: nearest, linear (default) or cubic")
      ->check(CLI::IsMember({"nearest", "linear", "cubic"}));
  command
      ->add_option("--arithmetic", flags->arithmetic,
                   "Precision in which sample positions are computed: float (default) or double")
      ->check(CLI::IsMember({"float", "double"}));
  command
      ->add_option(
          "--stations-mixed", flags->stations_mixed,
          "Stations mixed at the point where a ray crosses a line: both neighbours (2, default) "
          "or the nearer one (1)")
      ->check(CLI::Range(1, 2));
  command
      ->add_option("--station-stride", flags->station_stride,
                   "Use every n-th station of a line (default 1)")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--distance-maps", flags->distance_maps,
                   "Distance maps that a view's distances are gathered from (default 4)")
      ->check(CLI::Range(1, 4));
  command
      ->add_option("--fill-stations", flags->fill_stations,
                   "Stations searched for points hidden from the lines in use (default 32)")
      ->check(CLI::Range(0, 32));
  command
      ->add_option(
          "--second-side", flags->second_side,
          "When a two-sided view reads the second side: blend (default, wherever both see a "
          "point) or where-hidden (only where the nearer one does not)")
      ->check(CLI::IsMember({"blend", "where-hidden"}));
  command
      ->add_option(
          "--skip-px", flags->skip_px,
          "Skip work that would move a pixel by at most this many captured pixels (default 0: "
          "skip nothing)")
      ->check(CLI::Range(0.0, 4.0));
  command->add_flag("--no-gains", flags->no_gains,
                    "Show the panoramas' own exposures instead of those made equal by the room's "
                    "gains (raywalk-build-lf gains)");
}

void add_connection_flags(CLI::App* command, ViewFlags* flags) {
  command->add_option("--settings", flags->settings,
                      "YAML file of settings; flags override it (see configs/view.yaml)");
  command->option_defaults()->group(kConnectionGroup);
  command
      ->add_option("--connection", flags->connection,
                   "Where lines connect: hybrid (default), lfu (k = 45) or rayspace360 (k = 90)")
      ->check(CLI::IsMember(kConnections));
  command->add_option("--k", flags->k_deg,
                      "Largest incidence angle of the hybrid connection in degrees, 45 to 90; auto "
                      "(default): the one that connect-error measured to be best on the room, "
                      "else 90");
  command->add_option(
      "--layers", flags->layers,
      "Depth layers; auto (default): as many as --tolerance-px needs, for the scene "
      "that the room's require.json describes");
  command
      ->add_option("--tolerance-px", flags->tolerance_px,
                   "Largest shift of a pixel caused by automatic layers (default 0.5)")
      ->check(CLI::Range(0.01, 100.0));
  command
      ->add_option("--overlap-deg", flags->overlap_deg,
                   "Width of the blend at a connection, degrees (default 5)")
      ->check(CLI::Range(0.0, 45.0));
  add_trade_flags(command, flags);
}

// --budget-ms and --min-psnr-db, for rooms that a trade was measured on.
void add_demand_flags(CLI::App* command, Demand* demand) {
  command->option_defaults()->group(kTradeGroup);
  command->add_option(
      "--budget-ms", demand->budget_ms,
      "Use the most accurate setting that renders a panorama within this many milliseconds, "
      "as measured on the room by raywalk-render trade");
  command
      ->add_option("--min-psnr-db", demand->min_psnr_db,
                   "Use the fastest setting that reached this PSNR in that measurement")
      ->check(CLI::Range(0.0, 100.0));
}

void add_view_flags(CLI::App* command, ViewFlags* flags) {
  command
      ->add_option("--generation", flags->generation,
                   "initial (vertical cut), hlf-vd (default; corrected by distance) or two-sided "
                   "(corrected, from both sides)")
      ->check(CLI::IsMember(kGenerations));
  command
      ->add_option("--width", flags->width_px,
                   "Width of the picture in pixels, a multiple of 4 (default: as captured)")
      ->check(CLI::Range(4, 32768));
  add_connection_flags(command, flags);
}

void add_flat_flags(CLI::App* command, ViewFrame* frame) {
  command->option_defaults()->group(kDirectionGroup);
  command
      ->add_option(
          "--fov-deg", frame->fov_deg,
          "Horizontal field of view in degrees of a flat picture; without it a panorama is "
          "rendered")
      ->check(CLI::Range(1e-3, kMaxFovDeg));
  command->add_option("--size", frame->size,
                      "Size of the flat picture, WIDTHxHEIGHT in pixels (default 1280x720)");
}

void add_view(CLI::App* app, Arguments* arguments) {
  CLI::App* view = app->add_subcommand("view", "Render one view as a picture");
  add_room(view, arguments);
  add_point_option(view, "--at", &arguments->at,
                   "Viewpoint X,Z in metres, in the frame of poses.csv")
      ->required();
  view->add_option("-o,--out", arguments->out,
                   "Picture to write, .png or .jpg (default: view.png)");
  add_view_flags(view, &arguments->flags);
  add_demand_flags(view, &arguments->demand);
  add_threads_option(view, &arguments->threads);
  view->option_defaults()->group(kDirectionGroup);
  view->add_option("--yaw-deg", arguments->frame.yaw_deg, "Turn to the right, degrees");
  view->add_option("--pitch-deg", arguments->frame.pitch_deg, "Look up, degrees");
  view->add_option("--roll-deg", arguments->frame.roll_deg, "Tilt the camera clockwise, degrees");
  add_flat_flags(view, &arguments->frame);
  view->footer(
      "Examples:\n  raywalk-render view room.lf --at -0.1,0.25 -o view.png\n"
      "  raywalk-render view room.lf --at -0.1,0.25 --yaw-deg 40 --pitch-deg -10 --fov-deg 90 "
      "--size 1440x1600 --out eye.png");
  view->callback([arguments] {
    set_thread_count(arguments->threads);
    const PlanPoint viewpoint = viewpoint_from_text(arguments->at);
    view_settings(arguments->flags);  // reports contradictions before any work
    require_demand(arguments->demand);
    viewport_of(arguments->frame);
    if (arguments->out.empty()) arguments->out = "view.png";
    require_writable_picture(arguments->out);
    const Room room = Room::open(arguments->room);
    fmt::print("{}\n", escaped(write_view(room, chosen_mode(*arguments, room), viewpoint,
                                          arguments->frame, arguments->out)));
  });
}

void add_path(CLI::App* app, Arguments* arguments) {
  CLI::App* path = app->add_subcommand("path", "Render many views, one picture each");
  add_room(path, arguments);
  path->add_option(
          "path", arguments->path,
          "CSV table of views: columns name,x,z (metres) and optionally yaw,pitch,roll (degrees)")
      ->required();
  path->add_option("-o,--out", arguments->out,
                   "Directory for <name>.png, created if it is missing (default: the table's name "
                   "without .csv)");
  add_force_flag(path, &arguments->force,
                 "Replace the views in --out, which were rendered with other settings");
  add_view_flags(path, &arguments->flags);
  add_demand_flags(path, &arguments->demand);
  add_flat_flags(path, &arguments->frame);
  add_threads_option(path, &arguments->threads);
  path->footer(
      "Example:\n  raywalk-render path room.lf path.csv --generation two-sided --out views\n"
      "An interrupted run is resumed by the same command.");
  path->callback([arguments] {
    set_thread_count(arguments->threads);
    viewport_of(arguments->frame);
    view_settings(arguments->flags);
    require_demand(arguments->demand);
    if (arguments->out.empty()) {
      arguments->out = std::filesystem::path(arguments->path).stem().string();
    }
    const Room room = Room::open(arguments->room);
    fmt::print("{}\n", escaped(write_path(room, chosen_mode(*arguments, room), arguments->frame,
                                          arguments->path, arguments->out, arguments->force)));
  });
}

void add_validate(CLI::App* app, Arguments* arguments) {
  CLI::App* command =
      app->add_subcommand("validate", "Measure rendered views against captured ground truth");
  add_room(command, arguments);
  command
      ->add_option(
          "--truth", arguments->validate.truth,
          "CSV table of true views: columns file,x,y,z (metres) and optionally mask (pictures, "
          "0 = not compared)")
      ->required();
  add_report(command, &arguments->validate.report,
             "Directory for index.html and metrics.json, created if it is missing (default: "
             "<room>-validate)");
  command
      ->add_option("--generation", arguments->generations,
                   "Generations to render (default: all that the room supports)")
      ->delimiter(',')
      ->check(CLI::IsMember(kGenerations));
  command
      ->add_option("--viewpoints", arguments->validate.connect.viewpoints,
                   "Viewpoints per side of a cell for the connection error")
      ->check(CLI::Range(1, 250))
      ->capture_default_str();
  add_threads_option(command, &arguments->threads);
  add_connection_flags(command, &arguments->flags);
  command->footer(
      "Example:\n  raywalk-render validate room.lf --truth gt.csv --report report\n"
      "An interrupted run is resumed by the same command.");
  command->callback([arguments] {
    set_thread_count(arguments->threads);
    view_settings(arguments->flags);
    const Room room = Room::open(arguments->room);
    const ViewSettings settings =
        chosen_settings(arguments->flags, arguments->demand, room).settings;
    arguments->validate.connect.overlap_deg = settings.overlap_deg;
    arguments->validate.report = report_of(arguments->validate.report, arguments->room, "validate");
    arguments->validate.modes = view_modes(settings, arguments->generations, room);
    fmt::print("{}\n", validate(room, arguments->validate));
  });
}

void add_connect_error(CLI::App* app, Arguments* arguments) {
  ConnectErrorOptions* options = &arguments->connect_error;
  CLI::App* command = app->add_subcommand(
      "connect-error", "Measure how well neighbouring lines connect and store it in the room");
  add_room(command, arguments);
  command->add_option("--generation", arguments->generations, "Generations to measure")
      ->delimiter(',')
      ->check(CLI::IsMember(kGenerations))
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
  command->footer(
      "Example:\n  raywalk-render connect-error room.lf --generation initial,hlf-vd\n"
      "view, path, validate and trade with --k auto then use the k of the least error over the "
      "corners that are readable at every k.");
  command->callback([arguments, options] {
    set_thread_count(arguments->threads);
    std::vector<Generation> generations;
    for (const std::string& name : arguments->generations) {
      generations.push_back(generation_from_name(name));
    }
    if (generations.empty()) generations.push_back(Generation::kInitial);
    write_connect_error(Room::open(arguments->room), generations, *options, std::cout);
  });
}

void add_error_model(CLI::App* app, Arguments* arguments) {
  ErrorModelOptions* options = &arguments->error_model;
  CLI::App* command =
      app->add_subcommand("error-model", "Compute the paper's Fig. 11: errors over the angle k");
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

void add_trade(CLI::App* app, Arguments* arguments) {
  TradeOptions* options = &arguments->trade;
  CLI::App* command =
      app->add_subcommand("trade", "Measure time and accuracy of the rendering settings");
  add_room(command, arguments);
  command->add_option("--truth", options->truth,
                      "CSV table of true views: columns file,x,y,z (metres) and optionally mask "
                      "(pictures, 0 = not compared)");
  command
      ->add_option(
          "--held-out", options->held_out,
          "Leave out every n-th station and use it as a true view, in addition to --truth or "
          "instead of it")
      ->check(CLI::Range(2, 1'000'000));
  add_report(command, &options->report,
             "Directory for index.html, trade.json and trade.csv, created if it is missing "
             "(default: <room>-trade)");
  command->add_option(
      "--also", options->also,
      "Another room of the same place, packed at another width or with other distances; may "
      "be repeated");
  command->add_flag(
      "--full", options->full,
      "Also sweep combinations of settings that interact, with every true view: about a "
      "thousand settings (default: about 40, with 6 views)");
  command->add_option("--repetitions", options->repetitions, "How often every view is timed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-render trade room.lf --truth gt.csv --report trade\n"
      "  raywalk-render trade room.lf --held-out 8 --report trade\n"
      "The result is stored in the room for view --budget-ms and --min-psnr-db.\n"
      "An interrupted run is resumed by the same command.");
  command->callback([arguments, options] {
    set_thread_count(arguments->threads);
    const Room room = Room::open(arguments->room);
    options->report = report_of(options->report, arguments->room, "trade");
    options->centres = view_modes(view_settings({}), {}, room);
    options->presets = preset_modes(room);
    fmt::print("{}\n", trade(room, *options));
  });
}

}  // namespace
}  // namespace raywalk::render

int main(int argc, char** argv) {
  CLI::App app("Renders 360-degree views of a room at any viewpoint between its lines",
               "raywalk-render");
  app.set_version_flag("--version", std::string("raywalk-render " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer("Example:\n  raywalk-render view room.lf --at -0.1,0.25 --out view.png");
  raywalk::render::Arguments arguments;
  raywalk::render::add_view(&app, &arguments);
  raywalk::render::add_path(&app, &arguments);
  raywalk::render::add_validate(&app, &arguments);
  raywalk::render::add_connect_error(&app, &arguments);
  raywalk::render::add_error_model(&app, &arguments);
  raywalk::render::add_trade(&app, &arguments);
  return raywalk::run_program(app, argc, argv);
}
