#include "capture/import/picture_times.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

using std::chrono::microseconds;

// FAT, the file system of cards up to 32 GB, keeps even seconds ("FAT: General Overview of On-Disk
// Format" 1.03, section "Date and Time Formats").
constexpr double kFileTimeResolution_s = 2.0;

std::optional<int> digits(std::string_view text) {
  int value = 0;
  if (text.empty() ||
      !std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; })) {
    return std::nullopt;
  }
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{}) return std::nullopt;
  return value;
}

// Exif's "YYYY:MM:DD HH:MM:SS".
std::optional<WallTime> parse_date(std::string_view text) {
  if (text.size() != 19 || text[4] != ':' || text[7] != ':' || text[10] != ' ' || text[13] != ':' ||
      text[16] != ':') {
    return std::nullopt;
  }
  const auto year = digits(text.substr(0, 4));
  const auto month = digits(text.substr(5, 2));
  const auto day = digits(text.substr(8, 2));
  const auto hour = digits(text.substr(11, 2));
  const auto minute = digits(text.substr(14, 2));
  const auto second = digits(text.substr(17, 2));
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year{*year},
                                         std::chrono::month{static_cast<unsigned>(*month)},
                                         std::chrono::day{static_cast<unsigned>(*day)}};
  if (!date.ok() || *year == 0 || *hour > 23 || *minute > 59 || *second > 60) return std::nullopt;
  return std::chrono::sys_days{date} + std::chrono::hours{*hour} + std::chrono::minutes{*minute} +
         std::chrono::seconds{*second};
}

// "+02:00" or "-05:30"; empty if the camera wrote blanks.
std::optional<std::chrono::minutes> parse_utc_offset(std::string_view text) {
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-') || text[3] != ':') {
    return std::nullopt;
  }
  const auto hours = digits(text.substr(1, 2));
  const auto minutes = digits(text.substr(4, 2));
  if (!hours || !minutes || *hours > 14 || *minutes > 59) return std::nullopt;
  const std::chrono::minutes offset = std::chrono::hours{*hours} + std::chrono::minutes{*minutes};
  return text[0] == '-' ? -offset : offset;
}

// Decimals of a second: "7" is 0.7 s, "070" is 0.070 s.
void add_subseconds(std::string_view text, PictureTime* time) {
  text = text.substr(0, 6);  // WallTime resolves microseconds
  const auto decimals = digits(text);
  if (!decimals) return;
  const double step_s = std::pow(10.0, -static_cast<double>(text.size()));
  time->time += microseconds{std::llround(*decimals * step_s * 1e6)};
  time->resolution_s = step_s;
}

std::optional<PictureTime> time_of(const ExifTags& exif) {
  const auto shown = parse_date(exif.text(EXIF_TAG_DATE_TIME_ORIGINAL));
  if (!shown) return std::nullopt;
  PictureTime time{*shown, 1.0, PictureTimeSource::kExifLocal, {}};
  add_subseconds(exif.text(EXIF_TAG_SUB_SEC_TIME_ORIGINAL), &time);
  if (const auto utc_offset = parse_utc_offset(exif.text(EXIF_TAG_OFFSET_TIME_ORIGINAL))) {
    time.time -= *utc_offset;
    time.utc_offset = *utc_offset;
    time.source = PictureTimeSource::kExifUtc;
  }
  return time;
}

// The local time of the camera's clock, for times from Exif.
PictureTime as_local(PictureTime time) {
  time.time += time.utc_offset;
  time.utc_offset = std::chrono::minutes{0};
  if (time.source == PictureTimeSource::kExifUtc) time.source = PictureTimeSource::kExifLocal;
  return time;
}

PictureTime file_time(const std::filesystem::path& picture) {
  struct stat status {};
  if (stat(picture.c_str(), &status) != 0) {
    throw Error(fmt::format("{}: cannot be read: {}", picture.string(), std::strerror(errno)));
  }
  const Duration since_epoch = std::chrono::seconds{status.st_mtim.tv_sec} +
                               std::chrono::nanoseconds{status.st_mtim.tv_nsec};
  return {WallTime{std::chrono::duration_cast<WallTime::duration>(since_epoch)},
          kFileTimeResolution_s,
          PictureTimeSource::kFile,
          {}};
}

}  // namespace

std::string name_of(PictureTimeSource source) {
  switch (source) {
    case PictureTimeSource::kExifUtc:
      return "Exif time";
    case PictureTimeSource::kExifLocal:
      return "Exif local time";
    case PictureTimeSource::kFile:
      return "file time";
  }
  return "time";
}

std::optional<PictureTime> exif_time(const std::filesystem::path& picture) {
  constexpr std::size_t kBeginning = std::size_t{1} << 20;  // Exif stands before the pixels
  const std::string bytes = read_file_prefix(picture, kBeginning);
  return time_of(ExifTags(std::as_bytes(std::span(bytes))));
}

std::vector<PictureTime> picture_times(std::span<const std::filesystem::path> pictures) {
  std::vector<PictureTime> times;
  times.reserve(pictures.size());
  bool all_utc = true;
  for (const std::filesystem::path& picture : pictures) {
    const PictureTime time = exif_time(picture).value_or(file_time(picture));
    const bool as_the_first = times.empty() || (time.source == PictureTimeSource::kFile) ==
                                                   (times[0].source == PictureTimeSource::kFile);
    if (!as_the_first) {
      const bool is_odd = time.source == PictureTimeSource::kFile;
      throw Error(fmt::format(
          "{}: no Exif time, while other pictures have one; the file is damaged or of another "
          "camera, import without it",
          (is_odd ? picture : pictures[0]).string()));
    }
    all_utc = all_utc && time.source == PictureTimeSource::kExifUtc;
    times.push_back(time);
  }
  if (!all_utc) std::transform(times.begin(), times.end(), times.begin(), as_local);
  return times;
}

}  // namespace raywalk::capture
