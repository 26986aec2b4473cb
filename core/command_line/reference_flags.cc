#include "core/command_line/reference_flags.h"

#include <fmt/chrono.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include "core/command_line/program_reference.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

constexpr const char* kHidden = "";  // CLI11's name of the group that a help text leaves out

// Today, or the day of SOURCE_DATE_EPOCH (reproducible-builds.org/specs/source-date-epoch), so that
// the same sources make the same page.
std::string date_of_page() {
  std::time_t time_s = std::time(nullptr);
  const char* epoch = std::getenv("SOURCE_DATE_EPOCH");
  if (const auto given_s = epoch == nullptr ? std::nullopt : parse_finite_number(epoch)) {
    time_s = static_cast<std::time_t>(*given_s);
  }
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(time_s));
}

}  // namespace

void add_reference_flags(CLI::App* app) {
  app->add_flag_callback(
         "--man",
         [app] { throw CLI::CallForVersion(man_page(reference_of(*app), date_of_page()), 0); })
      ->group(kHidden);
  app->add_option_function<std::string>("--completion",
                                        [app](const std::string&) {
                                          throw CLI::CallForVersion(
                                              bash_completion(reference_of(*app)), 0);
                                        })
      ->check(CLI::IsMember(std::vector<std::string>{"bash"}))
      ->group(kHidden);
}

}  // namespace raywalk
