// trade: time and accuracy of the settings.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/evaluate/trade.h"
#include "render/commands/commands.h"
#include "render/commands/report_option.h"
#include "render/commands/view_flags.h"

namespace raywalk::render {
namespace {

struct TradeArguments {
  std::string room{};
  TradeOptions options{};
  DeviceFlags device{};
  int threads = 0;
};

// All presets for a room.
std::vector<NamedOptions> presets_of(const Room& room) {
  const SceneNumbers scene = scene_numbers(room);
  std::vector<NamedOptions> presets;
  for (const std::string_view preset_name : kPresets) {
    const std::string name(preset_name);
    const Preset preset = preset_of(name, scene);
    presets.push_back({name, preset.reason, view_mode(preset.settings).options});
  }
  return presets;
}

void run(const TradeArguments& arguments) {
  set_thread_count(arguments.threads);
  const Room room = Room::open(arguments.room);
  TradeOptions options = arguments.options;
  options.report = report_of(options.report, arguments.room, "trade");
  for (const ViewMode& mode : view_modes({}, {}, room)) options.centres.push_back(mode.options);
  options.presets = presets_of(room);
  options.device = device_from_name(arguments.device.device);
  options.gpu_mb = arguments.device.gpu_mb;
  fmt::print("{}\n", trade(room, options));
}

}  // namespace

void add_trade(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("trade", "Measure time and accuracy of the rendering settings");
  auto arguments = std::make_shared<TradeArguments>();
  TradeOptions* options = &arguments->options;
  add_room(command, &arguments->room);
  command->add_option("--truth", options->truth,
                      "CSV table of true views: columns file,x,y,z (metres) and optionally mask "
                      "(pictures, 0 = not compared)");
  command
      ->add_option("--held-out", options->held_out,
                   "Hold out every n-th station and use it as a true view, instead of --truth")
      ->check(CLI::Range(2, 1'000'000));
  add_match_exposure(command, &options->match_exposure);
  add_report(command, &options->report,
             "Directory for index.html, trade.json and trade.csv, created if it is missing "
             "(default: <room>-trade)");
  command->add_option("--repetitions", options->repetitions, "How often every view is timed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_device_flags(command, "cpu", &arguments->device);
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Examples:\n  raywalk-render trade room.lf --truth gt.csv --report trade\n"
      "  raywalk-render trade room.lf --held-out 8 --report trade\n"
      "The result is stored in the room for view --budget-ms and --min-psnr-db.");
  add_resumption(command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
