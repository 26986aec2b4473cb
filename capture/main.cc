// raywalk-capture: captures the lines of a grid with a slider and a camera.
#include <CLI/CLI.hpp>
#include <string>

#include "capture/commands/commands.h"
#include "core/command_line/program.h"

int main(int argc, char** argv) {
  CLI::App app("Captures grids of 360-degree panoramas", "raywalk-capture");
  app.set_version_flag("--version", std::string("raywalk-capture " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer(
      "Example:\n  raywalk-capture plan capture.yaml\n"
      "  raywalk-capture run capture.yaml --session hall\n"
      "  raywalk-capture export hall");
  raywalk::capture::add_plan(&app);
  raywalk::capture::add_check(&app);
  raywalk::capture::add_home(&app);
  raywalk::capture::add_jog(&app);
  raywalk::capture::add_stop(&app);
  raywalk::capture::add_run(&app);
  raywalk::capture::add_status(&app);
  raywalk::capture::add_verify(&app);
  raywalk::capture::add_import(&app);
  raywalk::capture::add_export(&app);
  raywalk::capture::add_merge(&app);
  return raywalk::run_program(app, argc, argv);
}
