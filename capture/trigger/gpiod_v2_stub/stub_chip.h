// For tests: what stands behind the stand-in for libgpiod 2.x, to set up and to look at.
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

// Of a line, what a request made of it.
struct StubLine {
  bool is_requested = false;
  std::string consumer;
  gpiod_line_direction direction = GPIOD_LINE_DIRECTION_AS_IS;
  gpiod_line_edge edges = GPIOD_LINE_EDGE_NONE;
  gpiod_line_clock clock = GPIOD_LINE_CLOCK_REALTIME;
  bool active_low = false;
  bool active = true;  // logical; not what an output may start with
  std::deque<gpiod_edge_event> events;
};

// The one chip there is, at /dev/gpiochip7.
struct StubChip {
  std::array<StubLine, 4> lines;
  int open_error = 0;  // errno of the next calls; 0: they succeed
  int line_error = 0;
  int wait_error = 0;
  int living_objects = 0;  // made and not yet freed
};
StubChip& stub_chip();
