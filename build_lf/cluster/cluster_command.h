// The command line of `raywalk-build-lf cluster-plan`.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::build_lf {

// Adds the command to the program; it writes the plan and prints it.
void add_cluster_plan(CLI::App* app);

}  // namespace raywalk::build_lf
