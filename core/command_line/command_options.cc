#include "core/command_line/command_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

constexpr const char* kCommonGroup = "Options";  // CLI11's name of the first group of a help text

// Of --line-tolerance-mm and --same-station-mm.
constexpr double kLeastDistance_mm = 1e-6;
constexpr double kLargestDistance_mm = 1e6;

}  // namespace

void add_threads_option(CLI::App* command, int* threads) {
  command->add_option("--threads", *threads, "Threads to use; 0 = all cores")
      ->check(CLI::Range(0, 1024))
      ->group(kCommonGroup);
}

void add_line_tolerance_options(CLI::App* command, GridTolerance* tolerance) {
  const CLI::Validator distances(
      [](const std::string& text) {
        const auto value = parse_finite_number(text);
        return value && *value >= kLeastDistance_mm && *value <= kLargestDistance_mm
                   ? std::string()
                   : fmt::format("{} is not a number from {:g} to {:g}", text, kLeastDistance_mm,
                                 kLargestDistance_mm);
      },
      fmt::format("[{:g} - {:g}]", kLeastDistance_mm, kLargestDistance_mm));
  const auto add = [&](const char* name, std::optional<double>* metres, const char* help) {
    command
        ->add_option_function<double>(
            name, [metres](double mm) { *metres = mm * 1e-3; }, help)
        ->check(distances);
  };
  add("--line-tolerance-mm", &tolerance->off_line_m,
      "Largest distance of a station of poses.csv from its line, to the side and in height "
      "(default: a tenth of the spacing, half of it where lines are named)");
  add("--same-station-mm", &tolerance->same_station_m,
      "Distance within which two stations of poses.csv count as one (default: a 500th of the "
      "spacing)");
}

void add_resumption(CLI::App* command) {
  command->footer(command->get_footer() + "\n" + kResumption);
}

void add_force_flag(CLI::App* command, bool* force, const std::string& description) {
  command->add_flag("-f,--force", *force, description)->group(kCommonGroup);
}

CLI::Validator one_of(std::vector<std::string> words) {
  const std::string description = fmt::format("{{{}}}", fmt::join(words, ","));
  return {[words = std::move(words)](const std::string& text) {
            return std::ranges::find(words, text) != words.end()
                       ? std::string()
                       : excerpt(text) + " is not a valid choice" + suggestion(text, words);
          },
          description};
}

CLI::Option* takes_config(CLI::Option* option, ConfigKind kind) {
  return option->type_name(
      fmt::format("CONFIG:{{{}}}", fmt::join(shipped_config_names(kind), ",")));
}

void add_quiet_flag(CLI::App* app, const std::function<void(bool)>& silence) {
  std::vector<CLI::App*> commands = app->get_subcommands([](CLI::App*) { return true; });
  commands.push_back(app);
  for (CLI::App* command : commands) {
    const auto quiet = [command, silence](std::int64_t) {
      const CLI::Option* json = command->get_option_no_throw("--json");
      silence(json == nullptr || json->empty());
    };
    command->add_flag_function("-q,--quiet", quiet, "Print only warnings and errors")
        ->group(kCommonGroup);
  }
}

}  // namespace raywalk
