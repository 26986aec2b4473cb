// raywalk-simulate: stands in for a slider and a camera, or renders the capture of a virtual room.
#include <CLI/CLI.hpp>
#include <string>

#include "core/command_line/program.h"
#include "simulator/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Simulates rigs and rooms whose truth is known", "raywalk-simulate");
  app.set_version_flag("--version", std::string("raywalk-simulate " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer(
      "Example:\n  raywalk-simulate rig rehearsal-rig --out rig &\n"
      "  raywalk-simulate room virtual-room --out room");
  raywalk::capture::add_rig(&app);
  raywalk::capture::add_room(&app);
  return raywalk::run_program(app, argc, argv);
}
