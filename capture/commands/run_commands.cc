// run, home, jog, stop: the commands that move the slider.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "capture/commands/commands.h"
#include "capture/commands/config_arguments.h"
#include "capture/run/run_session.h"
#include "capture/run/set_up_moves.h"

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
