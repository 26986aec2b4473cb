#include "capture/slider/register_map_text.h"

#include <cstddef>

namespace raywalk::capture {
namespace {

constexpr int kNone = -1;
// Function 16 writes at most 123 registers (Modbus application protocol 1.1b3, 6.12).
constexpr std::size_t kMaxWords = 123;
// From one step per metre to steps of 0.1 nm; values outside are mistakes of units.
constexpr double kMinScale = 1e-3;
constexpr double kMaxScale = 1e7;

void bind_write(SettingsSchema* schema, const std::string& key, WriteText* write) {
  schema->integer(key + ".address", &write->address, kNone, kLastAddress)
      .words(key + ".words", &write->words, kMaxWords);
}

void bind_bit(SettingsSchema* schema, const std::string& key, StatusBitText* bit) {
  schema->integer("status." + key + ".bit", &bit->bit, kNone, 15)
      .boolean("status." + key + ".active_low", &bit->active_low);
}

}  // namespace

SettingsSchema register_map_schema(RegisterMapText* text) {
  SettingsSchema schema;
  schema.text("name", &text->name)
      .number("steps_per_mm", &text->steps_per_mm, kMinScale, kMaxScale)
      .boolean("low_word_first", &text->low_word_first)
      .boolean("input_registers", &text->input_registers)
      .boolean("one_read", &text->one_read)
      .integer("position_address", &text->position_address, kNone, kLastAddress - 1)
      .integer("status_address", &text->status_address, kNone, kLastAddress)
      .integer("alarm_address", &text->alarm_address, kNone, kLastAddress)
      .number("speed_per_mm_s", &text->speed_per_mm_s, kMinScale, kMaxScale)
      .number("acceleration_per_mm_s2", &text->acceleration_per_mm_s2, 0.0, kMaxScale)
      .number("acceleration_time_to_mm_s", &text->acceleration_time_to_mm_s, 0.0, kMaxScale)
      .integer("identity.address", &text->identity_address, kNone, kLastAddress)
      .integer("identity.value", &text->identity_value, 0, 0xffff);
  bind_write(&schema, "move", &text->move);
  bind_write(&schema, "start", &text->start);
  bind_write(&schema, "home", &text->home);
  bind_write(&schema, "stop", &text->stop);
  bind_write(&schema, "reset_alarm", &text->reset_alarm);
  bind_bit(&schema, "alarm", &text->alarm);
  bind_bit(&schema, "enabled", &text->enabled);
  bind_bit(&schema, "homed", &text->homed);
  bind_bit(&schema, "moving", &text->moving);
  bind_bit(&schema, "in_position", &text->in_position);
  bind_bit(&schema, "at_low_limit", &text->at_low_limit);
  bind_bit(&schema, "at_high_limit", &text->at_high_limit);
  return schema;
}

}  // namespace raywalk::capture
