// run, home, jog, stop: the commands that move the slider.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "capture/commands/commands.h"
#include "capture/commands/config_arguments.h"
#include "capture/run/check_devices.h"
#include "capture/run/run_session.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

struct JogArguments {
  ConfigArguments config{};
  double mm = 0.0;
};

struct RunArguments {
  ConfigArguments config{};
  RunOptions options{};
};

// A slider moved by hand; a signal stops it before the program ends.
class SliderByHand {
 public:
  explicit SliderByHand(const SliderConfig& config)
      : slider_(open_slider(config, &clock_)),
        carriage_(slider_.get(), &clock_, limits_of(config), config.motion) {}

  Slider& slider() { return *slider_; }
  Carriage& carriage() { return carriage_; }
  std::string position_text() {
    return fmt::format("slider at {:.3f} mm", slider_->read_state().position_mm);
  }

 private:
  DeferStopSignals protection_;
  SystemClock clock_;
  std::unique_ptr<Slider> slider_;
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
      "Ctrl-C stops the slider and keeps what is captured; the same command resumes.\n"
      "Exit code 3: paused; fix the reported problem, then resume.");
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
