// The options of the steps, shared by the commands of single steps and `all`.
#pragma once

#include <string>

#include "calibrate/chain/calibration.h"
#include "core/command_line/command_options.h"

namespace CLI {
class App;
}

namespace raywalk::calibrate {

// The values of the command line; must outlive the command.
struct StepArguments {
  CalibrationOptions options{};
  std::string input{};
  std::string out{};
  std::string lens_start{};
  std::string lens_file{};
  std::string blend = "multi-band";
  std::string mask_picture{};
  std::string pose_table{};
  bool no_balance = false;
  std::string work{};  // COLMAP's directory
  int threads = 0;
};

void add_input(CLI::App* command, StepArguments* arguments);
void add_lens_options(CLI::App* command, StepArguments* arguments);
void add_stitch_options(CLI::App* command, StepArguments* arguments);
void add_mask_options(CLI::App* command, StepArguments* arguments);
void add_poses_options(CLI::App* command, StepArguments* arguments);

// The parsed options. Throws UsageError for a lens file that is neither a file nor shipped.
CalibrationOptions options_of(const StepArguments& arguments);

}  // namespace raywalk::calibrate
