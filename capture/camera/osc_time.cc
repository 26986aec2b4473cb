#include "capture/camera/osc_time.h"

#include <ctime>
#include <iomanip>
#include <locale>
#include <sstream>

namespace raywalk::capture {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// "+08:00": the zone's time minus UTC.
std::optional<std::chrono::minutes> zone_of(const std::string& text) {
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-') || text[3] != ':' ||
      !is_digit(text[1]) || !is_digit(text[2]) || !is_digit(text[4]) || !is_digit(text[5])) {
    return std::nullopt;
  }
  const std::chrono::minutes offset{(text[1] - '0') * 600 + (text[2] - '0') * 60 +
                                    (text[4] - '0') * 10 + (text[5] - '0')};
  return text[0] == '-' ? -offset : offset;
}

}  // namespace

std::optional<WallTime> time_from_date_time_zone(const std::string& text) {
  std::tm fields{};
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  in >> std::get_time(&fields, "%Y:%m:%d %H:%M:%S");
  std::string rest;
  std::getline(in, rest);
  const std::chrono::year_month_day date{
      std::chrono::year{fields.tm_year + 1900},
      std::chrono::month{static_cast<unsigned>(fields.tm_mon + 1)},
      std::chrono::day{static_cast<unsigned>(fields.tm_mday)}};
  const auto zone = zone_of(rest);
  if (!date.ok() || !zone) return std::nullopt;
  return std::chrono::sys_days{date} + std::chrono::hours{fields.tm_hour} +
         std::chrono::minutes{fields.tm_min} + std::chrono::seconds{fields.tm_sec} - *zone;
}

}  // namespace raywalk::capture
