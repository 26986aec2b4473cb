#include "core/command_line/command_options.h"

#include <CLI/CLI.hpp>

namespace raywalk {
namespace {

constexpr const char* kCommonGroup = "Options";  // CLI11's name of the first group of a help text

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

void add_force_flag(CLI::App* command, bool* force, const std::string& description) {
  command->add_flag("-f,--force", *force, description)->group(kCommonGroup);
}

void add_quiet_flag(CLI::App* app, const std::function<void(bool)>& silence) {
  add_quiet_to(app, silence);
  for (CLI::App* command : app->get_subcommands([](CLI::App*) { return true; })) {
    add_quiet_to(command, silence);
  }
}

}  // namespace raywalk
