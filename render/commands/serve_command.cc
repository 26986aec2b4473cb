// serve: a room in a browser.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/commands/web_flags.h"
#include "render/serve/serve_room.h"
#include "render/web/export_web.h"

namespace raywalk::render {
namespace {

struct ServeArguments {
  std::string room{};
  ServeOptions serve{};
  WebFlags web{};
  DeviceFlags device{};
  int threads = 0;
};

// What is exported already stays as it is.
void require_unused(const std::vector<CLI::Option*>& options) {
  for (const CLI::Option* option : options) {
    if (option->count() == 0) continue;
    throw UsageError("--export is a room exported already; give " + option->get_name() +
                     " to raywalk-render export-web");
  }
}

void run(const ServeArguments& arguments) {
  set_thread_count(arguments.threads);
  use_device(arguments.device);
  const WebExportOptions options = web_options(arguments.room, arguments.web);
  const Room room = web_room(arguments.room, arguments.web);
  const auto export_room = [&](const std::filesystem::path& folder) {
    fmt::print("{}\n", export_web(room, options, folder, false));
    std::fflush(stdout);
  };
  serve_room(room, arguments.serve, export_room, interrupt_requested);
}

}  // namespace

void add_serve(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "serve", "Show the room in a browser, still views rendered by this program");
  auto arguments = std::make_shared<ServeArguments>();
  add_room(command, &arguments->room);
  command->add_option("--export", arguments->serve.exported,
                      "Serve this folder, made by raywalk-render export-web, instead of "
                      "exporting the room for the time of serving");
  command
      ->add_option("--host", arguments->serve.host,
                   "Address to listen on (default: 127.0.0.1, this computer alone); with any "
                   "other, such as 0.0.0.0, the printed address has a token that browsers need")
      ->type_name("ADDRESS");
  command->add_option("--port", arguments->serve.port, "Port to listen on (default: 8360); 0: any")
      ->check(CLI::Range(0, 65535));
  add_device_flags(command, "auto", &arguments->device);
  add_threads_option(command, &arguments->threads);
  const std::vector<CLI::Option*> for_export = add_web_flags(command, &arguments->web);
  command->footer(
      "Prints the address to open; Ctrl-C ends it.\n"
      "Examples:\n  raywalk-render serve room.lf\n"
      "  raywalk-render export-web room.lf --out web\n"
      "  raywalk-render serve room.lf --export web --host 0.0.0.0 --port 8000");
  command->callback([arguments, for_export] {
    if (!arguments->serve.exported.empty()) require_unused(for_export);
    run(*arguments);
  });
}

}  // namespace raywalk::render
