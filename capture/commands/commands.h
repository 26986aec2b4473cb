// The commands of raywalk-capture. Each function adds one to the program's command line, with its
// options, an example and the call that does the work.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::capture {

// Before a session: the plan, and a check of every device.
void add_plan(CLI::App* app);
void add_check(CLI::App* app);
// Moving the slider by hand, for setting up.
void add_home(CLI::App* app);
void add_jog(CLI::App* app);
void add_stop(CLI::App* app);
// Capturing a session and working on it.
void add_run(CLI::App* app);
void add_status(CLI::App* app);
void add_verify(CLI::App* app);
void add_import(CLI::App* app);
void add_export(CLI::App* app);
void add_merge(CLI::App* app);

}  // namespace raywalk::capture
