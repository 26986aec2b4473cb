#include "capture/slider/register_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "core/base/error.h"
#include "core/files/settings.h"
#include "core/files/words.h"

namespace raywalk::capture {
namespace {

struct NamedMeaning {
  const char* name;
  WordMeaning meaning;
};
constexpr std::array kMeanings{NamedMeaning{"position_high", WordMeaning::kPositionHigh},
                               NamedMeaning{"position_low", WordMeaning::kPositionLow},
                               NamedMeaning{"speed", WordMeaning::kSpeed},
                               NamedMeaning{"speed_high", WordMeaning::kSpeedHigh},
                               NamedMeaning{"speed_low", WordMeaning::kSpeedLow},
                               NamedMeaning{"acceleration", WordMeaning::kAcceleration},
                               NamedMeaning{"deceleration", WordMeaning::kDeceleration}};
// One request reads at most 125 registers (Modbus application protocol 1.1b3, 6.3).
constexpr int kMaxReadAtOnce = 125;
// Function 16 writes at most 123 (6.12).
constexpr std::size_t kMaxWords = 123;
constexpr int kNone = -1;  // an address or bit that the drive does not have
constexpr int kLastAddress = 0xffff;
// From one step per metre to steps of 0.1 nm; values outside are mistakes of units.
constexpr double kMinScale = 1e-3;
constexpr double kMaxScale = 1e7;

// A map's file: its keys, bound to the map. The words of writes are texts until they are parsed.
// Every error starts with the file's name.
class RegisterMapFile {
 public:
  explicit RegisterMapFile(std::string source) : source_(std::move(source)) {
    map_.steps_per_mm = 0.0;  // until it is read
    map_.speed_per_mm_s = 0.0;
  }
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
    for (WriteText* write : {&move_, &start_, &home_, &stop_, &reset_alarm_}) {
      schema.integer(write->key + ".address", &write->address, kNone, kLastAddress)
          .words(write->key + ".words", &write->words, kMaxWords);
    }
    for (BitText& each : bits_) {
      schema.integer("status." + each.key + ".bit", &each.read.bit, kNone, 15)
          .boolean("status." + each.key + ".active_low", &each.read.active_low);
    }
    return schema;
  }

  // Once the schema has read the file.
  RegisterMap checked_map() {
    map_.move = write(move_);
    map_.start = optional_write(start_);
    map_.home = write(home_);
    map_.stop = write(stop_);
    map_.reset_alarm = optional_write(reset_alarm_);
    for (const BitText& each : bits_) {
      if (each.read.bit >= 0) *each.bit = each.read;
    }
    check(map_);
    return map_;
  }

 private:
  struct WriteText {
    std::string key;
    int address = kNone;
    std::vector<std::string> words{};  // numbers, or names such as "position_high"
  };
  struct BitText {
    std::string key;
    std::optional<StatusBit>* bit;
    StatusBit read{.bit = kNone, .active_low = false};
  };

  [[noreturn]] void fail(const std::string& what) const { throw UsageError(source_ + ": " + what); }

  void require_address(const char* key, int address) const {
    if (address < 0) fail(fmt::format("'{}' is missing", key));
  }

  void check(const RegisterMap& map) const {
    if (map.name.empty()) fail("'name' is missing; it names the drive in messages");
    require_address("position_address", map.position_address);
    require_address("status_address", map.status_address);
    if (map.steps_per_mm == 0.0) fail("'steps_per_mm' is missing");
    if (map.speed_per_mm_s == 0.0) fail("'speed_per_mm_s' is missing");
    if ((map.acceleration_per_mm_s2 > 0.0) == (map.acceleration_time_to_mm_s > 0.0)) {
      fail("give one of 'acceleration_per_mm_s2' and 'acceleration_time_to_mm_s'");
    }
    check_move_words(map);
    check_fixed_words("home", map.home);
    check_fixed_words("stop", map.stop);
    if (map.start) check_fixed_words("start", *map.start);
    if (map.reset_alarm) check_fixed_words("reset_alarm", *map.reset_alarm);
    if (map.alarm_address >= 0 && !map.alarm) {
      fail("'alarm_address' needs 'status.alarm.bit', which says when to read it");
    }
    if (!map.alarm) fail("'status.alarm.bit' is missing; it is needed to notice a failed drive");
    check_one_read(map);
  }

  BlockWord word(const std::string& key, const std::string& text) const {
    for (const NamedMeaning& named : kMeanings) {
      if (text == named.name) return {named.meaning, 0};
    }
    const auto number = parse_whole_or_hexadecimal_number(text);
    if (number && *number >= 0 && *number <= 0xffff) {
      return {WordMeaning::kConstant, static_cast<std::uint16_t>(*number)};
    }
    if (number) fail(fmt::format("'{}.words': {} does not fit 16 bits", key, text));
    std::vector<std::string> names(kMeanings.size());
    std::transform(kMeanings.begin(), kMeanings.end(), names.begin(),
                   [](const NamedMeaning& named) { return named.name; });
    fail(fmt::format("'{}.words': {} is neither a number nor a quantity{}", key, excerpt(text),
                     suggestion(text, names)));
  }

  RegisterWrite write(const WriteText& text) const {
    if (text.address < 0) fail(fmt::format("'{}.address' is missing", text.key));
    if (text.words.empty()) fail(fmt::format("'{}.words' is missing", text.key));
    if (text.address + static_cast<int>(text.words.size()) - 1 > kLastAddress) {
      fail(fmt::format("'{}' reaches beyond register 0xffff", text.key));
    }
    RegisterWrite write{text.address, {}};
    for (const std::string& each : text.words) write.words.push_back(word(text.key, each));
    return write;
  }

  std::optional<RegisterWrite> optional_write(const WriteText& text) const {
    if (text.address < 0 && text.words.empty()) return std::nullopt;
    return write(text);
  }

  static auto count(const RegisterWrite& write, WordMeaning meaning) {
    return std::count_if(write.words.begin(), write.words.end(),
                         [=](const BlockWord& word) { return word.meaning == meaning; });
  }

  void check_move_words(const RegisterMap& map) const {
    if (count(map.move, WordMeaning::kPositionHigh) != 1 ||
        count(map.move, WordMeaning::kPositionLow) != 1) {
      fail("'move.words' must hold position_high and position_low once each");
    }
    if (count(map.move, WordMeaning::kSpeedHigh) != count(map.move, WordMeaning::kSpeedLow)) {
      fail("'move.words' must hold speed_high and speed_low together");
    }
  }

  void check_fixed_words(const char* key, const RegisterWrite& write) const {
    if (count(write, WordMeaning::kConstant) != static_cast<std::ptrdiff_t>(write.words.size())) {
      fail(fmt::format("'{}.words' must be numbers; only a move has a position and a speed", key));
    }
  }

  void check_one_read(const RegisterMap& map) const {
    const int first = std::min(map.position_address, map.status_address);
    const int last = std::max(map.position_address + 1, map.status_address);
    if (map.one_read && last - first + 1 > kMaxReadAtOnce) {
      fail(
          fmt::format("'one_read': {} registers lie between status and position, and one request "
                      "reads at most {}",
                      last - first + 1, kMaxReadAtOnce));
    }
  }

  std::string source_;
  RegisterMap map_{};
  WriteText move_{"move"}, start_{"start"}, home_{"home"}, stop_{"stop"};
  WriteText reset_alarm_{"reset_alarm"};
  std::array<BitText, 7> bits_{{{"alarm", &map_.alarm},
                                {"enabled", &map_.enabled},
                                {"homed", &map_.homed},
                                {"moving", &map_.moving},
                                {"in_position", &map_.in_position},
                                {"at_low_limit", &map_.at_low_limit},
                                {"at_high_limit", &map_.at_high_limit}}};
};

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

}  // namespace raywalk::capture
