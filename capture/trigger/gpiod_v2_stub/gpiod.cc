#include "gpiod.h"

#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "stub_chip.h"

struct gpiod_chip {};
struct gpiod_chip_info {};
struct gpiod_line_info {
  std::string consumer;
};
struct gpiod_line_settings {
  StubLine line;
};
struct gpiod_line_config {
  std::vector<std::pair<unsigned int, StubLine>> lines;
};
struct gpiod_request_config {
  std::string consumer;
};
struct gpiod_line_request {
  unsigned int offset;
};
struct gpiod_edge_event_buffer {
  gpiod_edge_event event;
};

StubChip& stub_chip() {
  static StubChip chip;
  return chip;
}

namespace {

template <typename T>
T* make(T object = {}) {
  ++stub_chip().living_objects;
  return new T(std::move(object));
}

template <typename T>
void destroy(T* object) {
  --stub_chip().living_objects;
  delete object;
}

// 0, or -1 with errno as the library leaves them.
int outcome(int error) {
  if (error == 0) return 0;
  errno = error;
  return -1;
}

StubLine& line_of(const gpiod_line_request* request) {
  return stub_chip().lines.at(request->offset);
}

}  // namespace

gpiod_chip* gpiod_chip_open(const char* path) {
  const int error = std::strcmp(path, "/dev/gpiochip7") == 0 ? stub_chip().open_error : ENOENT;
  return outcome(error) == 0 ? make<gpiod_chip>() : nullptr;
}
void gpiod_chip_close(gpiod_chip* chip) { destroy(chip); }
gpiod_chip_info* gpiod_chip_get_info(gpiod_chip* /*chip*/) { return make<gpiod_chip_info>(); }
gpiod_line_info* gpiod_chip_get_line_info(gpiod_chip* /*chip*/, unsigned int offset) {
  return make<gpiod_line_info>({stub_chip().lines.at(offset).consumer});
}
gpiod_line_request* gpiod_chip_request_lines(gpiod_chip* /*chip*/, gpiod_request_config* req_cfg,
                                             gpiod_line_config* line_cfg) {
  const auto& [offset, wanted] = line_cfg->lines.at(0);
  StubLine& line = stub_chip().lines.at(offset);
  if (outcome(line.is_requested ? EBUSY : stub_chip().line_error) != 0) return nullptr;
  line = wanted;
  line.is_requested = true;
  line.consumer = req_cfg->consumer;
  return make<gpiod_line_request>({offset});
}

void gpiod_chip_info_free(gpiod_chip_info* info) { destroy(info); }
const char* gpiod_chip_info_get_label(gpiod_chip_info* /*info*/) { return "stub"; }
std::size_t gpiod_chip_info_get_num_lines(gpiod_chip_info* /*info*/) {
  return stub_chip().lines.size();
}

void gpiod_line_info_free(gpiod_line_info* info) { destroy(info); }
const char* gpiod_line_info_get_consumer(gpiod_line_info* info) {
  return info->consumer.empty() ? nullptr : info->consumer.c_str();
}

gpiod_line_settings* gpiod_line_settings_new() { return make<gpiod_line_settings>(); }
void gpiod_line_settings_free(gpiod_line_settings* settings) { destroy(settings); }
int gpiod_line_settings_set_direction(gpiod_line_settings* settings,
                                      gpiod_line_direction direction) {
  settings->line.direction = direction;
  return 0;
}
int gpiod_line_settings_set_edge_detection(gpiod_line_settings* settings, gpiod_line_edge edge) {
  settings->line.edges = edge;
  return 0;
}
void gpiod_line_settings_set_active_low(gpiod_line_settings* settings, bool active_low) {
  settings->line.active_low = active_low;
}
int gpiod_line_settings_set_event_clock(gpiod_line_settings* settings,
                                        gpiod_line_clock event_clock) {
  settings->line.clock = event_clock;
  return 0;
}
int gpiod_line_settings_set_output_value(gpiod_line_settings* settings, gpiod_line_value value) {
  settings->line.active = value == GPIOD_LINE_VALUE_ACTIVE;
  return 0;
}

gpiod_line_config* gpiod_line_config_new() { return make<gpiod_line_config>(); }
void gpiod_line_config_free(gpiod_line_config* config) { destroy(config); }
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned int* offsets,
                                        std::size_t num_offsets, gpiod_line_settings* settings) {
  for (std::size_t i = 0; i < num_offsets; ++i) {
    config->lines.emplace_back(offsets[i], settings->line);
  }
  return 0;
}

gpiod_request_config* gpiod_request_config_new() { return make<gpiod_request_config>(); }
void gpiod_request_config_free(gpiod_request_config* config) { destroy(config); }
void gpiod_request_config_set_consumer(gpiod_request_config* config, const char* consumer) {
  config->consumer = consumer;
}

void gpiod_line_request_release(gpiod_line_request* request) {
  line_of(request).is_requested = false;
  destroy(request);
}
gpiod_line_value gpiod_line_request_get_value(gpiod_line_request* request,
                                              unsigned int /*offset*/) {
  if (outcome(stub_chip().line_error) != 0) return GPIOD_LINE_VALUE_ERROR;
  return line_of(request).active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}
int gpiod_line_request_set_value(gpiod_line_request* request, unsigned int /*offset*/,
                                 gpiod_line_value value) {
  if (outcome(stub_chip().line_error) != 0) return -1;
  line_of(request).active = value == GPIOD_LINE_VALUE_ACTIVE;
  return 0;
}
int gpiod_line_request_wait_edge_events(gpiod_line_request* request, std::int64_t /*timeout_ns*/) {
  if (outcome(stub_chip().wait_error) != 0) return -1;
  return line_of(request).events.empty() ? 0 : 1;
}
int gpiod_line_request_read_edge_events(gpiod_line_request* request,
                                        gpiod_edge_event_buffer* buffer,
                                        std::size_t /*max_events*/) {
  buffer->event = line_of(request).events.front();
  line_of(request).events.pop_front();
  return 1;
}

gpiod_edge_event_type gpiod_edge_event_get_event_type(gpiod_edge_event* event) {
  return event->type;
}
std::uint64_t gpiod_edge_event_get_timestamp_ns(gpiod_edge_event* event) { return event->time_ns; }
gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(std::size_t /*capacity*/) {
  return make<gpiod_edge_event_buffer>();
}
void gpiod_edge_event_buffer_free(gpiod_edge_event_buffer* buffer) { destroy(buffer); }
gpiod_edge_event* gpiod_edge_event_buffer_get_event(gpiod_edge_event_buffer* buffer,
                                                    unsigned long /*index*/) {
  return &buffer->event;
}
