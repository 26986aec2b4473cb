#include "capture/camera/osc_time.h"

#include <ctime>
#include <iomanip>
#include <locale>
#include <sstream>

namespace raywalk::capture {
namespace {

// Parses the start of the text by the format, as UTC; `rest` is the remainder of the text.
std::optional<WallTime> parse_utc(const std::string& text, const char* format, std::string* rest) {
  std::tm fields{};
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  in >> std::get_time(&fields, format);
  if (in.fail()) return std::nullopt;
  std::getline(in, *rest);
  const std::chrono::year_month_day date{
      std::chrono::year{fields.tm_year + 1900},
      std::chrono::month{static_cast<unsigned>(fields.tm_mon + 1)},
      std::chrono::day{static_cast<unsigned>(fields.tm_mday)}};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days{date} + std::chrono::hours{fields.tm_hour} +
         std::chrono::minutes{fields.tm_min} + std::chrono::seconds{fields.tm_sec};
}

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
  std::string rest;
  const auto local = parse_utc(text, "%Y:%m:%d %H:%M:%S", &rest);
  const auto zone = zone_of(rest);
  if (!local || !zone) return std::nullopt;
  return *local - *zone;
}

std::optional<WallTime> time_from_http_date(const std::string& text) {
  std::string rest;
  const auto time = parse_utc(text, "%a, %d %b %Y %H:%M:%S", &rest);
  if (rest != " GMT") return std::nullopt;
  return time;
}

}  // namespace raywalk::capture
