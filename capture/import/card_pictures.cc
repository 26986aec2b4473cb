#include "capture/import/card_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// Insta360 names its JPEG files .insp.
constexpr std::array<std::string_view, 6> kExtensions = {".JPG",  ".JPEG", ".JPE",
                                                         ".JFIF", ".INSP", ".PNG"};
// FAT, the file system of cards up to 32 GB, keeps even seconds ("FAT: General Overview of On-Disk
// Format" 1.03, section "Date and Time Formats").
constexpr double kFileTimeResolution_s = 2.0;

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

// Some systems (macOS: "._R1.JPG") write hidden files of the same extension beside the pictures.
bool is_picture_name(const fs::path& file) {
  const std::string extension = upper_case(file.extension().string());
  const bool hidden = file.filename().string().starts_with('.');
  return !hidden && std::ranges::find(kExtensions, extension) != kExtensions.end();
}

std::vector<fs::path> pictures_in(const fs::path& directory) {
  std::vector<fs::path> pictures;
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(directory, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    if (entry->is_regular_file() && is_picture_name(entry->path())) {
      pictures.push_back(entry->path());
    }
  }
  if (failed) {
    throw Error(fmt::format("cannot read {}: {}", directory.string(), failed.message()));
  }
  if (pictures.empty()) {
    throw UsageError(
        fmt::format("{}: no .jpg, .jpeg, .insp or .png files in it", directory.string()));
  }
  return pictures;
}

std::vector<fs::path> files_of(std::span<const fs::path> files_and_directories) {
  std::vector<fs::path> files;
  for (const fs::path& each : files_and_directories) {
    const auto found = fs::is_directory(each) ? pictures_in(each) : std::vector{each};
    files.insert(files.end(), found.begin(), found.end());
  }
  if (files.empty()) throw UsageError("no pictures given to import; name files or a directory");
  std::set<fs::path> known;
  for (const fs::path& file : files) {
    std::error_code unknown;
    const fs::path canonical = fs::canonical(file, unknown);
    if (known.insert(unknown ? file : canonical).second) continue;
    throw UsageError(fmt::format("{} is given twice", file.string()));
  }
  return files;
}

struct PictureTime {
  WallTime shown{};  // by the camera's clock as if it showed UTC
  double resolution_s = kFileTimeResolution_s;
  bool is_exif = false;
  std::optional<std::chrono::minutes> utc_offset{};
};

// Exif's "YYYY:MM:DD HH:MM:SS". Cameras write "0000:00:00 00:00:00" if their clock was never set.
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
  time->resolution_s = std::pow(10.0, -static_cast<double>(decimals.size()));
  time->shown +=
      std::chrono::microseconds{std::llround(std::stoi(decimals) * time->resolution_s * 1e6)};
}

PictureTime time_of(const fs::path& file) {
  constexpr std::size_t kBeginning = std::size_t{1} << 20;  // Exif stands before the pixels
  const std::string bytes = read_file_prefix(file, kBeginning);
  const ExifTags exif(std::as_bytes(std::span(bytes)));
  PictureTime time;
  if (const auto shown = parse_date(exif.text(EXIF_TAG_DATE_TIME_ORIGINAL))) {
    time = {*shown, 1.0, true, parse_utc_offset(exif.text(EXIF_TAG_OFFSET_TIME_ORIGINAL))};
    add_subseconds(exif.text(EXIF_TAG_SUB_SEC_TIME_ORIGINAL), &time);
    return time;
  }
  std::error_code failed;
  const auto written = std::chrono::file_clock::to_sys(fs::last_write_time(file, failed));
  if (failed) {
    throw Error(fmt::format("{}: cannot be read: {}", file.string(), failed.message()));
  }
  time.shown = std::chrono::time_point_cast<WallTime::duration>(written);
  return time;
}

// Reads the times of all files, and sets those of the card.
std::vector<CardFile> read_times(const std::vector<fs::path>& files, CardPictures* card) {
  std::vector<PictureTime> times;
  times.reserve(files.size());
  for (const fs::path& file : files) {
    times.push_back(time_of(file));
    if (times.back().is_exif == times.front().is_exif) continue;
    throw Error(fmt::format(
        "{}: no Exif time, while other pictures have one; the file is damaged or of another "
        "camera, import without it",
        (times.back().is_exif ? files.front() : file).string()));
  }
  const bool all_utc = std::ranges::all_of(
      times, [](const PictureTime& time) { return time.utc_offset.has_value(); });
  card->time_source = all_utc                 ? "Exif time"
                      : times.front().is_exif ? "Exif local time"
                                              : "file time";
  card->resolution_s = std::ranges::max(times, {}, &PictureTime::resolution_s).resolution_s;
  std::vector<CardFile> timed;
  timed.reserve(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    WallTime time = times[i].shown;
    if (all_utc) time -= times[i].utc_offset.value();
    timed.push_back({files[i], time});
  }
  return timed;
}

constexpr std::array<std::pair<std::string_view, FrameLens>, 4> kHalfPrefixes{
    {{"GPFR", FrameLens::kFront},
     {"GPBK", FrameLens::kBack},
     {"GF", FrameLens::kFront},
     {"GB", FrameLens::kBack}}};

// What the names of the front and the back of a shot have in common, and which of them it is. Empty
// if the file is not named as half of a shot.
std::pair<std::string, FrameLens> half_name(const fs::path& file) {
  // DCF folders start with a number ("100GFRNT"); file names are unique within it.
  const std::string folder = file.parent_path().filename().string();
  const bool is_numbered = folder.find_first_not_of("0123456789") >= 3;
  const std::string name = upper_case(file.stem().string());
  for (const auto& [prefix, lens] : kHalfPrefixes) {
    if (!name.starts_with(prefix)) continue;
    return {(is_numbered ? folder.substr(0, 3) : "") + "/" + name.substr(prefix.size()), lens};
  }
  return {};
}

// The files of every shot, front then back. Empty if any file is not named as half of a shot.
std::map<std::string, std::map<FrameLens, CardFile>> pair_halves(
    const std::vector<CardFile>& files) {
  std::map<std::string, std::map<FrameLens, CardFile>> shots;
  for (const CardFile& file : files) {
    const auto [shot, lens] = half_name(file.file);
    if (shot.empty()) return {};
    const auto [half, is_new] = shots[shot].try_emplace(lens, file);
    half->second.lens = lens;
    if (is_new) continue;
    throw UsageError(
        fmt::format("{} and {} are both the same half of one shot; import them separately",
                    half->second.file.string(), file.file.string()));
  }
  return shots;
}

}  // namespace

CardPictures read_card(std::span<const fs::path> files_and_directories) {
  CardPictures card;
  const std::vector<CardFile> files = read_times(files_of(files_and_directories), &card);
  const auto pairs = pair_halves(files);
  for (const auto& [name, halves] : pairs) {
    const CardFile& first = halves.begin()->second;
    if (halves.size() == 2) {
      card.shots.push_back({first, halves.rbegin()->second});
    } else {
      card.unpaired.push_back(first.file);
    }
  }
  if (pairs.empty()) {
    for (const CardFile& file : files) card.shots.push_back({file});
  }
  std::ranges::sort(card.shots, {}, [](const CardShot& shot) {
    return std::pair(shot.front().time, shot.front().file.filename());
  });
  return card;
}

}  // namespace raywalk::capture
