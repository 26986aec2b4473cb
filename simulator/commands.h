// The commands of raywalk-simulate. Each function adds one to the program's command line, with its
// options, an example and the call that does the work.
#pragma once

namespace CLI {
class App;
}

namespace raywalk::capture {

void add_rig(CLI::App* app);
void add_room(CLI::App* app);

}  // namespace raywalk::capture
