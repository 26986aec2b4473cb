// plan, check: before anything moves.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/commands/commands.h"
#include "capture/commands/config_arguments.h"
#include "capture/plan/line_selection.h"
#include "capture/plan/plan_picture.h"
#include "capture/plan/plan_report.h"
#include "capture/run/check_devices.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/atomic_output.h"

namespace raywalk::capture {
namespace {

struct PlanArguments {
  std::string config{};
  std::string picture{};
  std::vector<std::string> lines{};
  bool json = false;
};

struct CheckArguments {
  ConfigArguments config{};
  std::string disk = ".";
  std::vector<std::string> lines{};
};

void plan(const PlanArguments& arguments) {
  const CaptureConfig config = read_capture_config(capture_config_file(arguments.config));
  const CapturePlan plan = select_lines(plan_capture(config), config.camera, arguments.lines);
  const PlanReport report = report_of(plan, config);
  const std::string picture =
      arguments.picture.empty()
          ? std::filesystem::path(arguments.config).stem().string() + "-plan.svg"
          : arguments.picture;
  write_file_atomically(picture, plan_picture_svg(plan));
  if (arguments.json) {
    fmt::print("{}\n", plan_report_json(report).dump(
                           2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  } else {
    fmt::print("{}picture:   {}\n", plan_report_text(report), escaped(picture));
  }
}

void check(const CheckArguments& arguments) {
  const auto checks = check_devices(config_of(arguments.config), arguments.disk, arguments.lines);
  fmt::print("{}", text_of(checks));
  if (!all_usable(checks)) throw Error("a run cannot start; see the lines marked FAILS");
}

}  // namespace

void add_plan(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "plan", "Report the planned session: stations, days, storage, batteries, resolution");
  auto arguments = std::make_shared<PlanArguments>();
  add_capture_config(command, &arguments->config);
  command->add_option("-o,--picture,--out", arguments->picture,
                      "SVG file to draw the plan to (default: <config>-plan.svg)");
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

}  // namespace raywalk::capture
