#include "calibrate/import/panorama_search.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions{".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};

std::optional<fs::path> existing(const fs::path& file) {
  if (fs::is_regular_file(file)) return file;
  // A name without an extension may have dots of its own.
  for (const char* extension : kExtensions) {
    fs::path added = file;
    added += extension;
    if (fs::is_regular_file(added)) return added;
  }
  for (const char* extension : kExtensions) {
    const fs::path replaced = fs::path(file).replace_extension(extension);
    if (fs::is_regular_file(replaced)) return replaced;
  }
  return std::nullopt;
}

fs::path file_of(const ImportedFrame& frame, const fs::path& folder) {
  for (const fs::path& name : {fs::path(frame.file), fs::path(frame.file).filename()}) {
    if (const auto file = existing(folder / name)) return *file;
  }
  throw Error(
      fmt::format("{}: there is no panorama {} in {}; put it there, or name another folder "
                  "with --panoramas",
                  frame.where, excerpt(frame.file), folder.string()));
}

bool is_picture(const fs::path& file) {
  const std::string extension = file.extension().string();
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

void warn_of_others(const std::vector<fs::path>& files, const fs::path& folder) {
  const std::set<fs::path> used(files.begin(), files.end());
  std::size_t others = 0;
  std::string first;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!is_picture(entry.path()) || used.contains(entry.path())) continue;
    ++others;
    if (first.empty() || entry.path().filename() < first) first = entry.path().filename();
  }
  if (others == 0) return;
  spdlog::warn("{}: {} pictures have no pose and are left out, such as {}", folder.string(), others,
               first);
}

}  // namespace

std::vector<fs::path> find_panoramas(const ImportedPoses& poses,
                                     const std::optional<fs::path>& folder) {
  const std::optional<fs::path> chosen = folder ? folder : poses.panoramas;
  if (!chosen) {
    throw UsageError(poses.kind + " does not tell where the panoramas are; give --panoramas");
  }
  if (!fs::is_directory(*chosen)) {
    throw Error(chosen->string() + ": no such folder of panoramas; give --panoramas");
  }
  std::vector<fs::path> files;
  std::set<fs::path> used;
  for (const ImportedFrame& frame : poses.frames) {
    files.push_back(file_of(frame, *chosen));
    if (!used.insert(files.back()).second) {
      throw Error(fmt::format("{}: {} has a pose already", frame.where, files.back().string()));
    }
    panorama_size_of(files.back());
  }
  warn_of_others(files, *chosen);
  return files;
}

}  // namespace raywalk::calibrate
