// raywalk-simulate: stands in for a slider and a camera, or renders the capture of a virtual room.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "capture/base/clock.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/command_line/program.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/json.h"
#include "core/files/shipped_configs.h"
#include "simulator/rig/rig.h"
#include "simulator/room/write_capture.h"

namespace raywalk::simulator {
namespace {

struct SimulateArguments {
  std::string config{};
  std::string out{};
  int threads = 0;
};

struct RoomArguments {
  std::string config{};
  std::optional<int> seed{};
  std::optional<int> width{};
  CaptureOptions capture{};
  int threads = 0;
};

VirtualRoomSettings settings_of(const RoomArguments& arguments) {
  VirtualRoomSettings settings = read_virtual_room_settings(
      named_config(arguments.config, ConfigKind::kVirtualRoom, "config"));
  if (arguments.seed) settings.seed = *arguments.seed;
  if (arguments.width) settings.output.width_px = *arguments.width;
  require_valid(settings, "--width");
  return settings;
}

// Runs a rig on the system clock until Ctrl-C or SIGTERM. When it is ready, `out`/rig.json appears
// and its path is printed:
//   {"slider": "<out>/slider", "modbus_port": 1502, "camera_url": "http://127.0.0.1:8080",
//    "pid": 4711}
// rig.json and the link of the serial port are removed at the end; card and truth are kept, and a
// later rig appends to them. Throws Error if another rig uses the directory, and as Rig does.
void simulate_rig(const RigConfig& config, const std::filesystem::path& out) {
  make_directories(out);
  const FileLock lock(out / "rig.lock", "another simulated rig uses it");
  const std::filesystem::path notice = out / "rig.json";
  std::filesystem::remove(notice);  // of a killed rig
  capture::SystemClock clock;
  const Rig rig(config, out, &clock);
  const nlohmann::json addresses = {
      {"slider", std::filesystem::absolute(rig.slider_device()).string()},
      {"modbus_port", rig.modbus_port()},
      {"camera_url", rig.camera_url()},
      {"pid", getpid()}};
  write_file_atomically(notice, json_text(addresses));
  fmt::print("{}\n", escaped(notice.string()));
  std::fflush(stdout);
  while (!interrupt_requested()) clock.sleep(std::chrono::milliseconds(100));
  std::filesystem::remove(notice);
}

void add_rig(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("rig", "Simulate a rig: a slider on a serial port, a camera on HTTP");
  auto arguments = std::make_shared<SimulateArguments>();
  takes_config(
      command->add_option("config", arguments->config,
                          "Settings: a file, or the name of one in configs, as simulated-rig"),
      ConfigKind::kRig)
      ->required();
  command
      ->add_option("-o,--out", arguments->out,
                   "Directory for the link to the port, the camera's card and the ground truth")
      ->default_val("rig");
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Example:\n  raywalk-simulate rig simulated-rig --out rig &\n"
      "  raywalk-capture run capture-osc --rig rig --session hall\n"
      "Runs until Ctrl-C.");
  command->callback([arguments] {
    set_thread_count(arguments->threads);
    simulate_rig(read_rig_config(named_config(arguments->config, ConfigKind::kRig, "config")),
                 arguments->out);
  });
}

void add_room(CLI::App* app) {
  auto arguments = std::make_shared<RoomArguments>();
  CLI::App* command = app->add_subcommand(
      "room", "Capture a virtual room with its ground truth: frames, views and distances");
  takes_config(
      command->add_option("config", arguments->config,
                          "Settings: a file, or the name of one in configs, as virtual-room"),
      ConfigKind::kVirtualRoom)
      ->required();
  command->add_option("-o,--out", arguments->capture.out,
                      "Directory to create (default: the settings' name without .yaml)");
  add_force_flag(command, &arguments->capture.replace, "Replace an earlier capture in --out");
  command->add_option("--seed", arguments->seed, "Override the seed of the settings")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--width", arguments->width,
                   "Override the panorama width of the settings, in pixels; a multiple of 4")
      ->check(CLI::Range(kLeastWidth_px, kLargestWidth_px));
  CLI::Option* views = command->add_option(
      "--views", arguments->capture.views,
      "CSV table of the ground-truth views to write: columns name,x,z, optionally y, in metres");
  command
      ->add_option("--truth-views", arguments->capture.truth_views,
                   "Number of ground-truth views, spread over the cells (default 12)")
      ->check(CLI::Range(0, 10000))
      ->excludes(views);
  command
      ->add_option("--every-distance", arguments->capture.distance_every,
                   "Write the distance map of every N-th station (default 8; 0 disables)")
      ->check(CLI::Range(0, 1000000));
  command->add_flag("--thin", arguments->capture.thin,
                    "Also write where the true views show thin structures, and gt_thin.csv for "
                    "raywalk-render validate --truth");
  command
      ->add_option(
          "--ods-ipd-mm", arguments->capture.ods_ipd_mm,
          "Also write the true views as raywalk-render view --stereo ods renders them, for eyes "
          "this many millimetres apart")
      ->check(CLI::Range(1.0, 200.0));
  add_threads_option(command, &arguments->threads);
  command->footer(
      "Example:\n  raywalk-simulate room virtual-room --out room\n"
      "  raywalk-build-lf pack --frames room/poses.csv --distance room/dist --out room.lf");
  command->callback([arguments] {
    set_thread_count(arguments->threads);
    if (arguments->capture.out.empty()) {
      arguments->capture.out = std::filesystem::path(arguments->config).stem();
    }
    const VirtualRoom room(settings_of(*arguments));
    fmt::print("{}\n", escaped(write_capture(room, arguments->capture)));
  });
}

}  // namespace
}  // namespace raywalk::simulator

int main(int argc, char** argv) {
  CLI::App app("Simulates rigs and rooms whose truth is known", "raywalk-simulate");
  app.set_version_flag("--version", std::string("raywalk-simulate " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer(
      "Example:\n  raywalk-simulate rig rehearsal-rig --out rig &\n"
      "  raywalk-simulate room virtual-room --out room");
  raywalk::simulator::add_rig(&app);
  raywalk::simulator::add_room(&app);
  return raywalk::run_program(app, argc, argv);
}
