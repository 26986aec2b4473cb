// raywalk-capture: drives slider and camera along the lines of a grid, or does so in a room that
// exists only in the computer.
#include <CLI/CLI.hpp>
#include <string>

#include "capture/commands/commands.h"
#include "core/base/program.h"

int main(int argc, char** argv) {
  CLI::App app("Captures grids of 360-degree panoramas", "raywalk-capture");
  app.set_version_flag("--version", std::string("raywalk-capture " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer(
      "Example:\n  raywalk-capture plan capture.yaml\n"
      "  raywalk-capture run capture.yaml --session hall\n"
      "  raywalk-capture export hall");
  raywalk::add_plan(&app);
  raywalk::add_check(&app);
  raywalk::add_home(&app);
  raywalk::add_jog(&app);
  raywalk::add_stop(&app);
  raywalk::add_run(&app);
  raywalk::add_status(&app);
  raywalk::add_verify(&app);
  raywalk::add_import(&app);
  raywalk::add_export(&app);
  raywalk::add_simulate(&app);
  raywalk::add_virtual_room(&app);
  return raywalk::run_program(app, argc, argv);
}
