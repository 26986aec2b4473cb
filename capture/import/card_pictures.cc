#include "capture/import/card_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// Insta360 names its JPEG files .insp.
constexpr std::array<std::string_view, 6> kExtensions = {".JPG",  ".JPEG", ".JPE",
                                                         ".JFIF", ".INSP", ".PNG"};

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
  std::set<fs::path> known;
  const auto add = [&](const fs::path& file) {
    std::error_code unknown;
    const fs::path canonical = fs::canonical(file, unknown);
    if (!known.insert(unknown ? file : canonical).second) {
      throw UsageError(fmt::format("{} is given twice", file.string()));
    }
    files.push_back(file);
  };
  for (const fs::path& each : files_and_directories) {
    if (fs::is_directory(each)) {
      for (const fs::path& file : pictures_in(each)) add(file);
    } else {
      add(each);
    }
  }
  if (files.empty()) throw UsageError("no pictures given to import; name files or a directory");
  return files;
}

struct LensPrefix {
  const char* text;
  FrameLens lens;
};
constexpr std::array kLensPrefixes{
    LensPrefix{"GPFR", FrameLens::kFront}, LensPrefix{"GPBK", FrameLens::kBack},
    LensPrefix{"GF", FrameLens::kFront}, LensPrefix{"GB", FrameLens::kBack}};

struct HalfShot {
  std::string key;  // equal for the front and back of a shot
  FrameLens lens = FrameLens::kBoth;
};

// DCF folders start with a number ("100GFRNT"); file names are unique within it.
std::string folder_number(const fs::path& file) {
  const std::string folder = file.parent_path().filename().string();
  const bool numbered =
      folder.size() >= 3 && std::all_of(folder.begin(), folder.begin() + 3,
                                        [](unsigned char c) { return std::isdigit(c) != 0; });
  return numbered ? folder.substr(0, 3) : "";
}

std::optional<HalfShot> half_shot(const fs::path& file) {
  const std::string name = upper_case(file.stem().string());
  for (const LensPrefix& prefix : kLensPrefixes) {
    if (!name.starts_with(prefix.text)) continue;
    const std::string rest = name.substr(std::string_view(prefix.text).size());
    return HalfShot{folder_number(file) + "/" + rest, prefix.lens};
  }
  return std::nullopt;
}

std::vector<CardShot> single_shots(const std::vector<fs::path>& files,
                                   const std::vector<PictureTime>& times) {
  std::vector<CardShot> shots;
  for (std::size_t i = 0; i < files.size(); ++i) {
    shots.push_back({times[i].time, {{files[i], FrameLens::kBoth}}});
  }
  return shots;
}

struct Halves {
  std::optional<std::size_t> front;
  std::optional<std::size_t> back;
};

// Empty if any file is not named as half of a shot.
std::map<std::string, Halves> halves_of(const std::vector<fs::path>& files) {
  std::map<std::string, Halves> halves;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto half = half_shot(files[i]);
    if (!half) return {};
    Halves& pair = halves[half->key];
    std::optional<std::size_t>& place = half->lens == FrameLens::kFront ? pair.front : pair.back;
    if (place) {
      throw UsageError(
          fmt::format("{} and {} are both the same half of one shot; import them separately",
                      files[*place].string(), files[i].string()));
    }
    place = i;
  }
  return halves;
}

}  // namespace

CardPictures read_card(std::span<const fs::path> files_and_directories) {
  const std::vector<fs::path> files = files_of(files_and_directories);
  const std::vector<PictureTime> times = picture_times(files);
  CardPictures card;
  card.source = times.front().source;
  card.resolution_s =
      std::max_element(times.begin(), times.end(), [](const auto& a, const auto& b) {
        return a.resolution_s < b.resolution_s;
      })->resolution_s;

  const std::map<std::string, Halves> halves = halves_of(files);
  if (halves.empty()) card.shots = single_shots(files, times);
  for (const auto& [key, pair] : halves) {
    if (pair.front && pair.back) {
      card.shots.push_back(
          {times[*pair.front].time,
           {{files[*pair.front], FrameLens::kFront}, {files[*pair.back], FrameLens::kBack}}});
    } else {
      card.unpaired.push_back(files[pair.front ? *pair.front : *pair.back]);
    }
  }
  std::sort(card.shots.begin(), card.shots.end(), [](const CardShot& a, const CardShot& b) {
    return std::pair(a.time, a.files.front().file.filename()) <
           std::pair(b.time, b.files.front().file.filename());
  });
  return card;
}

}  // namespace raywalk::capture
