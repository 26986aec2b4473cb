#include "capture/import/picture_times.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <regex>
#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

using std::chrono::microseconds;

// FAT, the file system of cards up to 32 GB, keeps even seconds ("FAT: General Overview of On-Disk
// Format" 1.03, section "Date and Time Formats").
constexpr double kFileTimeResolution_s = 2.0;

// Exif's "YYYY:MM:DD HH:MM:SS".
std::optional<WallTime> parse_date(const std::string& text) {
  static const std::regex form(R"((\d{4}):(\d\d):(\d\d) (\d\d):(\d\d):(\d\d))");
  std::smatch parts;
  if (!std::regex_match(text, parts, form)) return std::nullopt;
  const auto part = [&](std::size_t i) { return std::stoi(parts[i]); };
  const std::chrono::year_month_day date{std::chrono::year{part(1)},
                                         std::chrono::month{static_cast<unsigned>(part(2))},
                                         std::chrono::day{static_cast<unsigned>(part(3))}};
  const bool is_time = part(4) <= 23 && part(5) <= 59 && part(6) <= 60;
  if (!date.ok() || part(1) == 0 || !is_time) return std::nullopt;
  return std::chrono::sys_days{date} + std::chrono::hours{part(4)} + std::chrono::minutes{part(5)} +
         std::chrono::seconds{part(6)};
}

// "+02:00" or "-05:30"; empty if the camera wrote blanks.
std::optional<std::chrono::minutes> parse_utc_offset(const std::string& text) {
  static const std::regex form(R"(([+-])(\d\d):(\d\d))");
  std::smatch parts;
  if (!std::regex_match(text, parts, form)) return std::nullopt;
  const int hours = std::stoi(parts[2]), minutes = std::stoi(parts[3]);
  if (hours > 14 || minutes > 59) return std::nullopt;
  const std::chrono::minutes offset{60 * hours + minutes};
  return parts[1] == "-" ? -offset : offset;
}

// Decimals of a second: "7" is 0.7 s, "070" is 0.070 s.
void add_subseconds(const std::string& text, PictureTime* time) {
  const std::string decimals = text.substr(0, 6);  // WallTime resolves microseconds
  if (decimals.empty() || decimals.find_first_not_of("0123456789") != std::string::npos) return;
  const double step_s = std::pow(10.0, -static_cast<double>(decimals.size()));
  time->time += microseconds{std::llround(std::stoi(decimals) * step_s * 1e6)};
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
