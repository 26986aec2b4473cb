// raywalk-render: renders views of a room, and judges them.
#include <CLI/CLI.hpp>
#include <string>

#include "core/command_line/program.h"
#include "render/commands/commands.h"
#include "render/view/point_argument.h"

int main(int argc, char** argv) {
  CLI::App app("Renders 360-degree views of a room at any viewpoint between its lines",
               "raywalk-render");
  app.set_version_flag("--version", std::string("raywalk-render " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer("Example:\n  raywalk-render view room.lf --at -0.1,0.25 --out view.png");
  raywalk::render::add_view(&app);
  raywalk::render::add_path(&app);
  raywalk::render::add_export_web(&app);
  raywalk::render::add_serve(&app);
  raywalk::render::add_validate(&app);
  raywalk::render::add_connect_error(&app);
  raywalk::render::add_error_model(&app);
  raywalk::render::add_trade(&app);
  return raywalk::run_program(app, argc, argv, [&](const auto& words) {
    return raywalk::render::joined_points(app, words);
  });
}
