// The commands of raywalk-capture. Each function adds one to the program's command line, with its
// options, an example and the call that does the work.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::capture {

// Before a session: what it will be, and whether every device is there.
void add_plan(CLI::App* app);
void add_check(CLI::App* app);
// Moving by hand, for setting up.
void add_home(CLI::App* app);
void add_jog(CLI::App* app);
void add_stop(CLI::App* app);
// A session, and what is done with one.
void add_run(CLI::App* app);
void add_status(CLI::App* app);
void add_verify(CLI::App* app);
void add_import(CLI::App* app);
void add_export(CLI::App* app);
// Without hardware: a rig that is only simulated, and a room that is.
void add_simulate(CLI::App* app);
void add_virtual_room(CLI::App* app);

}  // namespace raywalk::capture
