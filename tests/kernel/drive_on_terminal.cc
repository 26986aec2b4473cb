// drive_on_terminal LINK: the simulated drive with the registers of configs/sliders/generic.yaml on
// a pseudo-terminal, to which LINK points. Prints "ready" and runs until it is killed.
#include <unistd.h>

#include <cstdio>
#include <exception>

#include "simulator/rig/drive_server.h"

int main(int argc, char** argv) {
  using namespace raywalk::simulator;
  if (argc != 2) return 2;
  try {
    const raywalk::capture::SystemClock clock;
    Faults faults(&clock);
    SimulatedDrive drive({}, &clock, &faults);
    const DriveServer server(
        {.serial_link = argv[1]},
        raywalk::capture::read_register_map(RAYWALK_CONFIGS "/sliders/generic.yaml"), &drive,
        &faults);
    std::puts("ready");
    std::fflush(stdout);
    while (true) pause();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "drive_on_terminal: %s\n", error.what());
    return 1;
  }
}
