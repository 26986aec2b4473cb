// For tests: the state of the stub of libgpiod 2.x, to set up and inspect.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>

#include "gpiod.h"

struct gpiod_edge_event {
  gpiod_edge_event_type type = GPIOD_EDGE_EVENT_RISING_EDGE;
  std::uint64_t time_ns = 0;
};

// The state of a line as requested.
struct StubLine {
  bool is_requested = false;
  std::string consumer;
  gpiod_line_direction direction = GPIOD_LINE_DIRECTION_AS_IS;
  gpiod_line_edge edges = GPIOD_LINE_EDGE_NONE;
  gpiod_line_clock clock = GPIOD_LINE_CLOCK_REALTIME;
  bool active_low = false;
  bool active =
      true;  // logical level; true, so that a test notices an output not set at its request
  std::deque<gpiod_edge_event> events;
};

// The only chip, at /dev/gpiochip7.
struct StubChip {
  std::array<StubLine, 4> lines;
  int open_error = 0;  // errno of the next calls; 0: they succeed
  int line_error = 0;
  int wait_error = 0;
  int living_objects = 0;  // created and not freed
};
StubChip& stub_chip();
