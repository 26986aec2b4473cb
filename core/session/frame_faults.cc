#include "core/session/frame_faults.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

}  // namespace

std::string file_fault(const SessionContents& contents, const SessionFrame& frame) {
  const fs::path file = contents.directory / frame.file;
  const auto fault = [&](const std::string& what) {
    return fmt::format("{} (station {}): {}", frame.file, contents.station_of(frame).name, what);
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) {
    return fault(error ? error.message() : std::string("No such file or directory"));
  }
  if (!fs::is_regular_file(status)) return fault("not a regular file");
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) return fault(error.message());
  if (bytes != static_cast<std::uintmax_t>(frame.bytes)) {
    return fault(fmt::format("{} bytes, {} were written", bytes, frame.bytes));
  }
  return "";
}

std::vector<FrameFault> incomplete_stations(const SessionContents& contents) {
  // As the session's first frame is: one file for both lenses, or two.
  const bool one_file = contents.frames.empty() || contents.frames.front().lens == FrameLens::kBoth;
  std::map<std::pair<int, int>, int> files;  // of a station and an exposure
  for (const SessionFrame& frame : contents.frames) ++files[{frame.station, frame.exposure}];
  std::vector<FrameFault> faults;
  for (std::size_t i = 0; i < contents.stations.size(); ++i) {
    const SessionStation& station = contents.stations[i];
    if (!station.shot || station.shot->on_card) continue;
    for (int exposure = 0; exposure < contents.exposures; ++exposure) {
      const int found = files[{static_cast<int>(i), exposure}];
      if (found == (one_file ? 1 : 2)) continue;
      faults.push_back(
          {station.name,
           found == 0
               ? fmt::format("station {}: has no frame of exposure {}", station.name, exposure)
               : fmt::format("station {}: exposure {} lacks the picture of a lens", station.name,
                             exposure)});
      break;
    }
  }
  return faults;
}

std::vector<FrameFault> frame_faults(const SessionContents& contents) {
  std::vector<FrameFault> faults = incomplete_stations(contents);
  for (const SessionFrame& frame : contents.frames) {
    std::string fault = file_fault(contents, frame);
    if (!fault.empty()) faults.push_back({contents.station_of(frame).name, std::move(fault)});
  }
  return faults;
}

void require_no_faults(const std::vector<FrameFault>& faults, const fs::path& directory) {
  if (faults.empty()) return;
  const std::string more =
      faults.size() > 1 ? fmt::format(" (and {} more faults)", faults.size() - 1) : "";
  throw Error(one_line(
      fmt::format("{0}: {1}{2}; restore the frames from a copy, or give up their stations with "
                  "'raywalk-capture verify {0} --give-up', so that they can be captured again",
                  directory.string(), faults.front().text, more)));
}

}  // namespace raywalk
