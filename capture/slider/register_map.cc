#include "capture/slider/register_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "capture/slider/register_map_text.h"
#include "core/base/error.h"
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

// Converts the text of a file to a map; every error starts with the file's name.
class MapBuilder {
 public:
  explicit MapBuilder(std::string source) : source_(std::move(source)) {}

  RegisterMap build(const RegisterMapText& text) const {
    RegisterMap map;
    map.name = text.name;
    map.steps_per_mm = text.steps_per_mm;
    map.low_word_first = text.low_word_first;
    map.input_registers = text.input_registers;
    map.one_read = text.one_read;
    map.position_address = text.position_address;
    map.status_address = text.status_address;
    map.alarm_address = text.alarm_address;
    map.speed_per_mm_s = text.speed_per_mm_s;
    map.acceleration_per_mm_s2 = text.acceleration_per_mm_s2;
    map.acceleration_time_to_mm_s = text.acceleration_time_to_mm_s;
    map.move = write("move", text.move);
    map.start = optional_write("start", text.start);
    map.home = write("home", text.home);
    map.stop = write("stop", text.stop);
    map.reset_alarm = optional_write("reset_alarm", text.reset_alarm);
    map.alarm = bit(text.alarm);
    map.enabled = bit(text.enabled);
    map.homed = bit(text.homed);
    map.moving = bit(text.moving);
    map.in_position = bit(text.in_position);
    map.at_low_limit = bit(text.at_low_limit);
    map.at_high_limit = bit(text.at_high_limit);
    map.identity_address = text.identity_address;
    map.identity_value = text.identity_value;
    return map;
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

 private:
  [[noreturn]] void fail(const std::string& what) const { throw UsageError(source_ + ": " + what); }

  void require_address(const char* key, int address) const {
    if (address < 0) fail(fmt::format("'{}' is missing", key));
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

  RegisterWrite write(const std::string& key, const WriteText& text) const {
    if (text.address < 0) fail(fmt::format("'{}.address' is missing", key));
    if (text.words.empty()) fail(fmt::format("'{}.words' is missing", key));
    if (text.address + static_cast<int>(text.words.size()) - 1 > kLastAddress) {
      fail(fmt::format("'{}' reaches beyond register 0xffff", key));
    }
    RegisterWrite write{text.address, {}};
    for (const std::string& each : text.words) write.words.push_back(word(key, each));
    return write;
  }

  std::optional<RegisterWrite> optional_write(const std::string& key, const WriteText& text) const {
    if (text.address < 0 && text.words.empty()) return std::nullopt;
    return write(key, text);
  }

  static std::optional<StatusBit> bit(const StatusBitText& text) {
    if (text.bit < 0) return std::nullopt;
    return StatusBit{text.bit, text.active_low};
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
};

}  // namespace

RegisterMap read_register_map(const std::filesystem::path& file) {
  RegisterMapText text;
  register_map_schema(&text).load(file);
  const MapBuilder builder(file.string());
  RegisterMap map = builder.build(text);
  builder.check(map);
  return map;
}

}  // namespace raywalk::capture
