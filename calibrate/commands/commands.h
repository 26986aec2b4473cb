// The commands of raywalk-calibrate. Each function adds one to the program's command line, with its
// options, an example and the call that does the work.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::calibrate {

// One step each, from what the steps before it have left.
void add_lens(CLI::App* app);
void add_stitch(CLI::App* app);
void add_mask(CLI::App* app);
void add_poses(CLI::App* app);
void add_grid(CLI::App* app);
void add_rectify(CLI::App* app);
// All of them.
void add_all(CLI::App* app);

}  // namespace raywalk::calibrate
