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
#include "capture/plan/plan_report.h"
#include "capture/run/check_devices.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/report/report.h"

namespace raywalk::capture {
namespace {

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

// A page of an earlier plan is replaced, anything else is not.
void require_replaceable_report(const std::filesystem::path& file) {
  constexpr std::string_view kSign = "<title>Raywalk report</title>";
  if (!std::filesystem::exists(file)) return;
  if (read_file_prefix(file, 4096).find(kSign) != std::string::npos) return;
  throw Error(file.string() + " is there already and is no report of Raywalk's");
}

void plan(const PlanArguments& arguments) {
  if (!arguments.report.empty()) require_replaceable_report(arguments.report);
  const CaptureConfig config = read_capture_config(capture_config_file(arguments.config));
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

}  // namespace raywalk::capture
