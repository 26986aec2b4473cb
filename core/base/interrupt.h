// Ctrl-C as a flag that long work looks at, so that it can stop in good order.
#pragma once

namespace raywalk {

// Installs handlers for SIGINT and SIGTERM that set a flag; a second SIGINT ends the process at
// once.
void install_interrupt_handlers();

// Whether the user has asked to stop.
bool interrupt_requested();

// Throws Interrupted if the user has asked to stop. Safe from any thread; cheap enough for every
// frame.
void throw_if_interrupted();

}  // namespace raywalk
