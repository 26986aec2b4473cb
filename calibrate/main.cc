// raywalk-calibrate: recovers the poses of a capture's panoramas and rectifies the frames, so that
// the lines agree where they cross.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <string>

#include "calibrate/commands/commands.h"
#include "core/command_line/program.h"

int main(int argc, char** argv) {
  // Ceres logs what it then reports as a failure, through glog. Only what aborts is to be seen.
  FLAGS_minloglevel = google::GLOG_FATAL;
  CLI::App app("Calibrates captured grids of 360-degree panoramas", "raywalk-calibrate");
  app.set_version_flag("--version", std::string("raywalk-calibrate " RAYWALK_VERSION));
  app.require_subcommand(1);
  app.footer(
      "Example:\n  raywalk-calibrate all hall --lens-start theta-like "
      "--cone-deg 25\n"
      "  raywalk-build-lf pack --frames hall/calibration/poses.csv --out hall.lf");
  raywalk::calibrate::add_lens(&app);
  raywalk::calibrate::add_stitch(&app);
  raywalk::calibrate::add_mask(&app);
  raywalk::calibrate::add_poses(&app);
  raywalk::calibrate::add_rectify(&app);
  raywalk::calibrate::add_all(&app);
  raywalk::calibrate::add_import(&app);
  return raywalk::run_program(app, argc, argv);
}
