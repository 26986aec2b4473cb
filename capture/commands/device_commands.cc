// plan, check, run, home, jog, stop: the commands that read the settings of a capture.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "capture/commands/commands.h"
#include "capture/config/capture_config.h"
#include "capture/plan/line_selection.h"
#include "capture/plan/plan_report.h"
#include "capture/run/check_devices.h"
#include "capture/run/run_session.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/command_line/command_options.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/report/report.h"

namespace raywalk::capture {
namespace {

struct ConfigArguments {
  std::string config{};
  std::string rig{};  // directory of a simulated rig; empty: the configured devices
};

struct PlanArguments {
  std::string config{};
  std::string report{};
  std::vector<std::string> lines{};
  bool json = false;
};

struct CheckArguments {
  ConfigArguments config{};
  std::string disk = ".";
  std::vector<std::string> lines{};
};

struct JogArguments {
  ConfigArguments config{};
  double mm = 0.0;
};

struct RunArguments {
  ConfigArguments config{};
  RunOptions options{};
};

// The settings of a capture, a positional argument: a path, or the name of one of Raywalk's own.
void add_capture_config(CLI::App* command, std::string* config) {
  takes_config(
      command->add_option("config", *config,
                          "Settings: a file, or the name of one in configs, as capture-osc"),
      ConfigKind::kCapture)
      ->required();
}

CaptureConfig read_config(const std::string& config) {
  return read_capture_config(named_config(config, ConfigKind::kCapture, "config"));
}

void add_config(CLI::App* command, ConfigArguments* arguments) {
  add_capture_config(command, &arguments->config);
  command->add_option("--rig", arguments->rig,
                      "Use the simulated rig that runs in this directory instead of the configured "
                      "devices");
}

CaptureConfig config_of(const ConfigArguments& arguments) {
  CaptureConfig config = read_config(arguments.config);
  if (!arguments.rig.empty()) use_rig_addresses(&config, arguments.rig);
  require_devices(config);
  return config;
}

// The words of select_lines (line_selection.h).
void add_lines(CLI::App* command, std::vector<std::string>* lines) {
  command
      ->add_option(
          "--lines", *lines,
          "Only these lines of the plan, as a session of their own: x0,x3-x5 (default: all)")
      ->type_name("LINES")
      ->delimiter(',');
}

// A page of an earlier plan is replaced, anything else is not.
void require_replaceable_report(const std::filesystem::path& file) {
  constexpr std::string_view kSign = "<title>Raywalk report</title>";
  if (!std::filesystem::exists(file)) return;
  if (read_file_prefix(file, 4096).find(kSign) != std::string::npos) return;
  throw Error(file.string() + " is there already and is no report of Raywalk's");
}

void plan(const PlanArguments& arguments) {
  if (!arguments.report.empty()) require_replaceable_report(arguments.report);
  const CaptureConfig config = read_config(arguments.config);
  const CapturePlan plan = select_lines(plan_capture(config), config.camera, arguments.lines);
  const nlohmann::ordered_json report = plan_report(plan, config);
  if (!arguments.report.empty()) {
    write_file_atomically(arguments.report, report_page("plan", report));
  }
  fmt::print("{}", arguments.json ? report.dump(2) + "\n" : plan_report_text(report));
}

void check(const CheckArguments& arguments) {
  bool usable = true;
  for (const DeviceCheck& device :
       check_devices(config_of(arguments.config), arguments.disk, arguments.lines)) {
    fmt::print("{:<7} {}  {}\n", device.device, device.usable ? "ok   " : "FAILS",
               one_line(device.text));
    usable &= device.usable;
  }
  if (!usable) throw Error("a run cannot start; see the lines marked FAILS");
}

// A slider moved by hand; a signal stops it before the program ends.
class SliderByHand {
 public:
  explicit SliderByHand(const SliderConfig& config)
      : slider_(open_slider(config, &clock_)),
        carriage_(slider_.get(), &clock_, limits_of(config), config.motion) {}

  ModbusSlider& slider() { return *slider_; }
  Carriage& carriage() { return carriage_; }
  std::string position_text() {
    return fmt::format("slider at {:.3f} mm", slider_->read_state().position_mm);
  }

 private:
  DeferStopSignals protection_;
  SystemClock clock_;
  std::unique_ptr<ModbusSlider> slider_;
  Carriage carriage_;
};

std::string home_slider(const SliderConfig& config) {
  SliderByHand by_hand(config);
  by_hand.carriage().home();
  return "homed; " + by_hand.position_text();
}

// Throws Error if the drive is not homed, UsageError if the move would leave the soft limits.
std::string jog_slider(const SliderConfig& config, double mm) {
  SliderByHand by_hand(config);
  const SliderState state = by_hand.slider().read_state();
  if (!state.homed.value_or(true)) {
    throw Error(by_hand.slider().description() +
                ": the drive is not homed; run raywalk-capture home first");
  }
  const SafePosition target = by_hand.carriage().limits().require(state.position_mm + mm, "jog");
  return fmt::format("slider at {:.3f} mm, moved by {:+.3f} mm",
                     by_hand.carriage().move_to(target).measured_mm, mm);
}

// Decelerates to a stop, also a motion that another program started.
std::string stop_slider(const SliderConfig& config) {
  SliderByHand by_hand(config);
  by_hand.carriage().stop();
  return "stopped; " + by_hand.position_text();
}

}  // namespace

void add_plan(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "plan", "Report the planned session: stations, days, storage, batteries, resolution");
  auto arguments = std::make_shared<PlanArguments>();
  add_capture_config(command, &arguments->config);
  command->add_option("-o,--report,--out", arguments->report,
                      "HTML file to write: the plan drawn from above, with its figures");
  add_lines(command, &arguments->lines);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer("Example:\n  raywalk-capture plan capture.yaml");
  command->callback([arguments] { plan(*arguments); });
}

void add_check(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("check", "Check slider, camera and disk without moving anything");
  auto arguments = std::make_shared<CheckArguments>();
  add_config(command, &arguments->config);
  command->add_option("--disk", arguments->disk,
                      "Directory for sessions, whose disk is checked (default: .)");
  add_lines(command, &arguments->lines);
  command->footer("Example:\n  raywalk-capture check capture.yaml");
  command->callback([arguments] { check(*arguments); });
}

void add_run(CLI::App* app) {
  CLI::App* command = app->add_subcommand("run", "Capture a session, or resume one");
  auto arguments = std::make_shared<RunArguments>();
  RunOptions* options = &arguments->options;
  add_config(command, &arguments->config);
  CLI::Option* session = command->add_option("--session", options->session,
                                             "Session directory; created, or resumed if it exists");
  CLI::Option* dry_run = command->add_flag("--dry-run", options->dry_run,
                                           "Move to every station without taking pictures");
  dry_run->excludes(session);
  add_lines(command, &options->lines);
  command->add_flag("--yes", options->yes, "Do not wait for an operator to place the rail");
  command->footer(
      "Example:\n  raywalk-capture run capture.yaml --session hall\n"
      "  raywalk-capture run capture.yaml --session monday --lines x0-x3\n"
      "Ctrl-C stops the slider and keeps what is captured.\n"
      "Exit code 3: paused; fix the reported problem, then resume.");
  add_resumption(command);
  command->callback([arguments] {
    if (!arguments->options.dry_run && arguments->options.session.empty()) {
      throw CLI::RequiredError("--session (or --dry-run)");
    }
    fmt::print("{}\n", run_session(config_of(arguments->config), arguments->options));
  });
}

void add_home(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("home", "Move the slider to its home switch and set 0 mm there");
  auto arguments = std::make_shared<ConfigArguments>();
  add_config(command, arguments.get());
  command->footer("Example:\n  raywalk-capture home capture.yaml");
  command->callback([arguments] { fmt::print("{}\n", home_slider(config_of(*arguments).slider)); });
}

void add_jog(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("jog", "Move the slider by a distance within its soft limits");
  auto arguments = std::make_shared<JogArguments>();
  add_config(command, &arguments->config);
  command->add_option("--mm", arguments->mm, "Distance in millimetres; negative towards home")
      ->required();
  command->footer("Example:\n  raywalk-capture jog capture.yaml --mm -25");
  command->callback([arguments] {
    fmt::print("{}\n", jog_slider(config_of(arguments->config).slider, arguments->mm));
  });
}

void add_stop(CLI::App* app) {
  CLI::App* command = app->add_subcommand("stop", "Stop the slider");
  auto arguments = std::make_shared<ConfigArguments>();
  add_config(command, arguments.get());
  command->footer(
      "Example:\n  raywalk-capture stop capture.yaml\n"
      "To stop a run in another terminal, press Ctrl-C there: it holds the port.");
  command->callback([arguments] { fmt::print("{}\n", stop_slider(config_of(*arguments).slider)); });
}

}  // namespace raywalk::capture
