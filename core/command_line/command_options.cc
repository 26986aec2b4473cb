#include "core/command_line/command_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <string_view>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

constexpr const char* kCommonGroup = "Options";  // CLI11's name of the first group of a help text

// Of --line-tolerance-mm and --same-station-mm.
constexpr double kLeastDistance_mm = 1e-6;
constexpr double kLargestDistance_mm = 1e6;

void add_quiet_to(CLI::App* command, const std::function<void(bool)>& silence) {
  command
      ->add_flag_function(
          "-q,--quiet",
          [command, silence](std::int64_t) {
            const CLI::Option* json = command->get_option_no_throw("--json");
            silence(json == nullptr || json->empty());
          },
          "Print only warnings and errors")
      ->group(kCommonGroup);
}

}  // namespace

void add_threads_option(CLI::App* command, int* threads) {
  command->add_option("--threads", *threads, "Threads to use; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->group(kCommonGroup);
}

void add_line_tolerance_options(CLI::App* command, LineToleranceArguments* arguments) {
  const CLI::Validator distances(
      [](const std::string& text) {
        const auto value = parse_finite_number(text);
        return value && *value >= kLeastDistance_mm && *value <= kLargestDistance_mm
                   ? std::string()
                   : fmt::format("{} is not a number from {:g} to {:g}", text, kLeastDistance_mm,
                                 kLargestDistance_mm);
      },
      fmt::format("[{:g} - {:g}]", kLeastDistance_mm, kLargestDistance_mm));
  command
      ->add_option("--line-tolerance-mm", arguments->line_tolerance_mm,
                   "Largest distance of a station of poses.csv from its line, to the side and in "
                   "height (default: a tenth of the spacing, half of it where lines are named)")
      ->check(distances);
  command
      ->add_option("--same-station-mm", arguments->same_station_mm,
                   "Distance within which two stations of poses.csv count as one (default: a 500th "
                   "of the spacing)")
      ->check(distances);
}

GridTolerance tolerance_of(const LineToleranceArguments& arguments) {
  const double line_mm = arguments.line_tolerance_mm, same_mm = arguments.same_station_mm;
  if (line_mm > 0.0 && same_mm > line_mm) {
    throw UsageError(
        fmt::format("--same-station-mm {:g} exceeds --line-tolerance-mm {:g}; stations that near "
                    "would count as one anywhere on a line",
                    same_mm, line_mm));
  }
  GridTolerance tolerance;
  if (line_mm > 0.0) tolerance.off_line_m = line_mm * 1e-3;
  if (same_mm > 0.0) tolerance.same_station_m = same_mm * 1e-3;
  return tolerance;
}

void add_force_flag(CLI::App* command, bool* force, const std::string& description) {
  command->add_flag("-f,--force", *force, description)->group(kCommonGroup);
}

CLI::Option* takes_config(CLI::Option* option, ConfigKind kind) {
  return option->type_name(
      fmt::format("CONFIG:{{{}}}", fmt::join(shipped_config_names(kind), ",")));
}

void add_quiet_flag(CLI::App* app, const std::function<void(bool)>& silence) {
  add_quiet_to(app, silence);
  for (CLI::App* command : app->get_subcommands([](CLI::App*) { return true; })) {
    add_quiet_to(command, silence);
  }
}

}  // namespace raywalk
