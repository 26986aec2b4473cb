#include "capture/slider/register_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "capture/base/units.h"
#include "core/base/error.h"
#include "core/files/settings.h"
#include "core/files/words.h"

namespace raywalk::capture {
namespace {

// In the order of WordMeaning, after kConstant.
constexpr std::array kQuantities{"position_high", "position_low", "speed",       "speed_high",
                                 "speed_low",     "acceleration", "deceleration"};
// One request reads at most 125 registers (Modbus application protocol 1.1b3, 6.3).
constexpr int kMaxReadAtOnce = 125;
// Function 16 writes at most 123 (6.12).
constexpr std::size_t kMaxWords = 123;
constexpr int kNone = -1;  // an address or bit that the drive does not have
constexpr int kLastAddress = 0xffff;
// From one step per metre to steps of 0.1 nm; values outside are mistakes of units.
constexpr double kMinScale = 1e-3;
constexpr double kMaxScale = 1e7;

constexpr double kLargest16 = 0xffff;
constexpr double kLargest32 = 0xffffffff;

// A map's file: its keys, bound to the map. The words of writes are texts until they are parsed.
// Every error starts with the file's name.
class RegisterMapFile {
 public:
  explicit RegisterMapFile(std::string source) : source_(std::move(source)) {}
  RegisterMapFile(const RegisterMapFile&) = delete;
  RegisterMapFile& operator=(const RegisterMapFile&) = delete;

  SettingsSchema schema() {
    SettingsSchema schema;
    schema.text("name", &map_.name)
        .number("steps_per_mm", &map_.steps_per_mm, kMinScale, kMaxScale)
        .boolean("low_word_first", &map_.low_word_first)
        .boolean("input_registers", &map_.input_registers)
        .boolean("one_read", &map_.one_read)
        .integer("position_address", &map_.position_address, kNone, kLastAddress - 1)
        .integer("status_address", &map_.status_address, kNone, kLastAddress)
        .integer("alarm_address", &map_.alarm_address, kNone, kLastAddress)
        .number("speed_per_mm_s", &map_.speed_per_mm_s, kMinScale, kMaxScale)
        .number("acceleration_per_mm_s2", &map_.acceleration_per_mm_s2, 0.0, kMaxScale)
        .number("acceleration_time_to_mm_s", &map_.acceleration_time_to_mm_s, 0.0, kMaxScale)
        .integer("identity.address", &map_.identity_address, kNone, kLastAddress)
        .integer("identity.value", &map_.identity_value, 0, 0xffff);
    for (Write& write : writes_) {
      schema.integer(write.key + ".address", &write.read->address, kNone, kLastAddress)
          .words(write.key + ".words", &write.words, kMaxWords);
    }
    for (const auto& [key, bit] : bits_) {
      schema.integer("status." + key + ".bit", &bit->bit, kNone, 15)
          .boolean("status." + key + ".active_low", &bit->active_low);
    }
    return schema;
  }

  // Once the schema has read the file.
  RegisterMap checked_map() {
    for (const Write& write : writes_) parse(write);
    require_keys();
    if ((map_.acceleration_per_mm_s2 > 0.0) == (map_.acceleration_time_to_mm_s > 0.0)) {
      fail("give one of 'acceleration_per_mm_s2' and 'acceleration_time_to_mm_s'");
    }
    check_move_words();
    check_one_read();
    return map_;
  }

 private:
  struct Write {
    std::string key;
    RegisterWrite* read;
    bool is_optional;
    std::vector<std::string> words{};  // numbers, or names such as "position_high"
  };

  [[noreturn]] void fail(const std::string& what) const { throw UsageError(source_ + ": " + what); }

  void parse(const Write& write) const {
    const int address = write.read->address;
    if (write.is_optional && address < 0 && write.words.empty()) return;
    if (address < 0) fail(fmt::format("'{}.address' is missing", write.key));
    if (write.words.empty()) fail(fmt::format("'{}.words' is missing", write.key));
    if (address + static_cast<int>(write.words.size()) - 1 > kLastAddress) {
      fail(fmt::format("'{}' reaches beyond register 0xffff", write.key));
    }
    for (const std::string& text : write.words) {
      const BlockWord word = parsed_word(write.key, text);
      if (word.meaning != WordMeaning::kConstant && write.read != &map_.move) {
        fail(fmt::format("'{}.words' must be numbers; only a move has a position and a speed",
                         write.key));
      }
      write.read->words.push_back(word);
    }
  }

  BlockWord parsed_word(const std::string& key, const std::string& text) const {
    const auto* const named = std::find(kQuantities.begin(), kQuantities.end(), text);
    if (named != kQuantities.end()) {
      return {static_cast<WordMeaning>(1 + (named - kQuantities.begin())), 0};
    }
    const auto number = parse_whole_or_hexadecimal_number(text);
    if (number && *number >= 0 && *number <= 0xffff) {
      return {WordMeaning::kConstant, static_cast<std::uint16_t>(*number)};
    }
    if (number) fail(fmt::format("'{}.words': {} does not fit 16 bits", key, text));
    fail(fmt::format("'{}.words': {} is neither a number nor a quantity{}", key, excerpt(text),
                     suggestion(text, {kQuantities.begin(), kQuantities.end()})));
  }

  void require_keys() const {
    for (const auto& [key, is_missing] : {std::pair{"name", map_.name.empty()},
                                          {"position_address", map_.position_address < 0},
                                          {"status_address", map_.status_address < 0},
                                          {"steps_per_mm", map_.steps_per_mm == 0.0},
                                          {"speed_per_mm_s", map_.speed_per_mm_s == 0.0}}) {
      if (is_missing) fail(fmt::format("'{}' is missing", key));
    }
    if (map_.alarm.bit < 0) {
      fail("'status.alarm.bit' is missing; it is needed to notice a failed drive");
    }
  }

  auto count_in_move(WordMeaning meaning) const {
    return std::count_if(map_.move.words.begin(), map_.move.words.end(),
                         [=](const BlockWord& word) { return word.meaning == meaning; });
  }

  void check_move_words() const {
    if (count_in_move(WordMeaning::kPositionHigh) != 1 ||
        count_in_move(WordMeaning::kPositionLow) != 1) {
      fail("'move.words' must hold position_high and position_low once each");
    }
    if (count_in_move(WordMeaning::kSpeedHigh) != count_in_move(WordMeaning::kSpeedLow)) {
      fail("'move.words' must hold speed_high and speed_low together");
    }
  }

  void check_one_read() const {
    const int first = std::min(map_.position_address, map_.status_address);
    const int last = std::max(map_.position_address + 1, map_.status_address);
    if (map_.one_read && last - first + 1 > kMaxReadAtOnce) {
      fail(
          fmt::format("'one_read': {} registers lie between status and position, and one request "
                      "reads at most {}",
                      last - first + 1, kMaxReadAtOnce));
    }
  }

  std::string source_;
  RegisterMap map_{};
  std::array<Write, 4> writes_{{{"move", &map_.move, false},
                                {"start", &map_.start, true},
                                {"home", &map_.home, false},
                                {"stop", &map_.stop, false}}};
  std::array<std::pair<std::string, StatusBit*>, 7> bits_{{{"alarm", &map_.alarm},
                                                           {"enabled", &map_.enabled},
                                                           {"homed", &map_.homed},
                                                           {"moving", &map_.moving},
                                                           {"in_position", &map_.in_position},
                                                           {"at_low_limit", &map_.at_low_limit},
                                                           {"at_high_limit", &map_.at_high_limit}}};
};

std::uint16_t high_word(std::uint32_t value) { return static_cast<std::uint16_t>(value >> 16); }
std::uint16_t low_word(std::uint32_t value) { return static_cast<std::uint16_t>(value & 0xffff); }

std::uint32_t whole_units(const RegisterMap& map, const char* what, double asked, double units,
                          double largest) {
  const double rounded = std::round(units);
  if (!(rounded >= 1.0 && rounded <= largest)) {
    throw UsageError(fmt::format(
        "register map '{}': {} {:g} would be {:g} in its register, which holds 1 to {:.0f}; choose "
        "another value, or correct the map's scale",
        map.name, what, asked, units, largest));
  }
  return static_cast<std::uint32_t>(rounded);
}

std::uint32_t speed_units(const RegisterMap& map, double speed_mm_s, double largest) {
  return whole_units(map, "speed in mm/s", speed_mm_s, speed_mm_s * map.speed_per_mm_s, largest);
}

// Either units of acceleration, or the milliseconds t in which it reaches the map's speed v: from
// v = a t, t = 1000 v / a.
std::uint32_t acceleration_units(const RegisterMap& map, double acceleration_mm_s2) {
  const double units = map.acceleration_time_to_mm_s > 0.0
                           ? kMsPerSecond * map.acceleration_time_to_mm_s / acceleration_mm_s2
                           : map.acceleration_per_mm_s2 * acceleration_mm_s2;
  return whole_units(map, "acceleration in mm/s^2", acceleration_mm_s2, units, kLargest16);
}

std::uint16_t word_of_write(const RegisterMap& map, const BlockWord& word, double target_mm,
                            const MotionProfile& profile) {
  const auto position = [&] { return static_cast<std::uint32_t>(steps_from_mm(map, target_mm)); };
  switch (word.meaning) {
    case WordMeaning::kConstant:
      return word.constant;
    case WordMeaning::kPositionHigh:
      return high_word(position());
    case WordMeaning::kPositionLow:
      return low_word(position());
    case WordMeaning::kSpeed:
      return low_word(speed_units(map, profile.speed_mm_s, kLargest16));
    case WordMeaning::kSpeedHigh:
      return high_word(speed_units(map, profile.speed_mm_s, kLargest32));
    case WordMeaning::kSpeedLow:
      return low_word(speed_units(map, profile.speed_mm_s, kLargest32));
    case WordMeaning::kAcceleration:
    case WordMeaning::kDeceleration:
      break;
  }
  return low_word(acceleration_units(map, profile.acceleration_mm_s2));
}

}  // namespace

RegisterMap read_register_map(const std::filesystem::path& file) {
  RegisterMapFile text(file.string());
  text.schema().load(file);
  return text.checked_map();
}

std::set<std::string> register_map_keys() {
  RegisterMapFile text("");
  std::set<std::string> keys;
  for (const auto& [key, value] : text.schema().values()) keys.insert(key);
  return keys;
}

std::int32_t steps_from_mm(const RegisterMap& map, double mm) {
  const double steps = std::round(mm * map.steps_per_mm);
  if (!(steps >= std::numeric_limits<std::int32_t>::min() &&
        steps <= std::numeric_limits<std::int32_t>::max())) {
    throw UsageError(fmt::format(
        "register map '{}': {:.3f} mm are {:.0f} steps, more than 32 bits hold; correct "
        "steps_per_mm",
        map.name, mm, steps));
  }
  return static_cast<std::int32_t>(steps);
}

double mm_from_words(const RegisterMap& map, std::uint16_t first, std::uint16_t second) {
  const std::uint32_t high = map.low_word_first ? second : first;
  const std::uint32_t low = map.low_word_first ? first : second;
  // Two's complement, as C++20 defines it.
  return static_cast<std::int32_t>(high << 16 | low) / map.steps_per_mm;
}

std::vector<std::uint16_t> words_of(const RegisterMap& map, const RegisterWrite& write,
                                    double target_mm, const MotionProfile& profile) {
  std::vector<std::uint16_t> words;
  words.reserve(write.words.size());
  for (const BlockWord& word : write.words) {
    words.push_back(word_of_write(map, word, target_mm, profile));
  }
  return words;
}

std::optional<bool> flag_of(std::uint16_t status, const StatusBit& bit) {
  if (bit.bit < 0) return std::nullopt;
  return ((status >> bit.bit & 1) != 0) != bit.active_low;
}

}  // namespace raywalk::capture
