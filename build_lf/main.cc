// raywalk-build-lf: packs captured frames into a room, estimates distances, inspects rooms.
#include <CLI/CLI.hpp>
#include <string>

#include "build_lf/commands/commands.h"
#include "core/command_line/program.h"

int main(int argc, char** argv) {
  CLI::App app("Packs 360-degree captures of a grid into light-field volumes", "raywalk-build-lf");
  app.set_version_flag("--version", std::string("raywalk-build-lf " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer("Example:\n  raywalk-build-lf all --frames poses.csv --out room.lf");
  raywalk::build_lf::add_all(&app);
  raywalk::build_lf::add_pack(&app);
  raywalk::build_lf::add_repack(&app);
  raywalk::build_lf::add_depth(&app);
  raywalk::build_lf::add_refine(&app);
  raywalk::build_lf::add_distances(&app);
  raywalk::build_lf::add_gains(&app);
  raywalk::build_lf::add_info(&app);
  raywalk::build_lf::add_verify(&app);
  raywalk::build_lf::add_require(&app);
  raywalk::build_lf::add_export(&app);
  return raywalk::run_program(app, argc, argv);
}
