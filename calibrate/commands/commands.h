// The commands of raywalk-calibrate. Each function adds one command with its options, an example
// and the callback that runs it.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::calibrate {

// One step each, from the results of the steps before it.
void add_lens(CLI::App* app);
void add_stitch(CLI::App* app);
void add_mask(CLI::App* app);
void add_poses(CLI::App* app);
void add_rectify(CLI::App* app);
// Poses of other programs instead of the steps.
void add_import(CLI::App* app);
// All steps.
void add_all(CLI::App* app);

}  // namespace raywalk::calibrate
