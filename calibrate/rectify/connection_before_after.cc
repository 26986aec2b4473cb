#include "calibrate/rectify/connection_before_after.h"

#include <fmt/format.h>

#include <map>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/room/connection_errors.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr int kWidestPicture = 1024;
constexpr const char* kGeneration = "initial";
// Sub-cells per side of a cell: their centres are the viewpoints.
constexpr const char* kViewpoints = "5";

// A temporary directory, removed with its contents.
class WorkDirectory {
 public:
  explicit WorkDirectory(fs::path directory) : directory_(std::move(directory)) {
    fs::remove_all(directory_);
    make_directories(directory_);
  }
  ~WorkDirectory() {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
  }
  WorkDirectory(const WorkDirectory&) = delete;
  WorkDirectory& operator=(const WorkDirectory&) = delete;

 private:
  fs::path directory_;
};

fs::path program_in(const std::optional<fs::path>& programs, const std::string& name) {
  std::error_code none;
  const fs::path directory =
      programs ? *programs : fs::read_symlink("/proc/self/exe", none).parent_path();
  fs::path program = directory / name;
  if (fs::is_regular_file(program, none)) return program;
  throw Error(
      fmt::format("{} does not exist; give its directory with --programs", program.string()));
}

void run(const fs::path& program, const std::vector<std::string>& arguments, const fs::path& log) {
  ChildProcess child(program, arguments, log);
  const int status = child.wait();
  if (succeeded(status)) return;
  const std::string output = one_line(read_file(log));
  constexpr std::string_view kError = "error: ";
  const std::size_t error = output.rfind(kError);
  throw Error(
      fmt::format("{} {}: {}", program.filename().string(), describe_failure(status),
                  error == std::string::npos ? output : output.substr(error + kError.size())));
}

cv::Mat shrunk(const cv::Mat& picture, cv::InterpolationFlags how) {
  cv::Mat result;
  cv::resize(picture, result, {kWidestPicture, kWidestPicture / 2}, 0.0, 0.0, how);
  return result;
}

// Frames with copies of pictures and masks at the measured width.
std::vector<ListedFrame> shrunk_frames(const std::vector<ListedFrame>& frames, PanoramaSize size,
                                       const fs::path& directory) {
  if (size.width <= kWidestPicture) return frames;
  make_directories(directory);
  std::vector<ListedFrame> listed = frames;
  std::map<std::string, std::string> masks;  // many frames may share one file
  for (ListedFrame& frame : listed) {
    if (frame.mask.empty()) continue;
    const auto [known, is_new] = masks.emplace(frame.mask, "");
    if (is_new) {
      known->second = (directory / fmt::format("mask_{}.png", masks.size())).string();
      write_image(known->second, shrunk(read_mask(frame.mask, size), cv::INTER_NEAREST));
    }
    frame.mask = known->second;
  }
  parallel_for(0, static_cast<int>(listed.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const fs::path file = directory / fmt::format("{}.png", i);
      ListedFrame& frame = listed[static_cast<std::size_t>(i)];
      write_image(file, shrunk(read_panorama(frame.file), cv::INTER_AREA));
      frame.file = file.string();
    }
  });
  return listed;
}

ConnectionErrorMeasurement measure(const ConnectionInput& input, PanoramaSize size,
                                   const std::optional<fs::path>& programs, const fs::path& work,
                                   Progress* progress) {
  const WorkDirectory directory(work);
  const auto grid = grid_of(input.frames, input.lines, input.tolerance);
  if (!grid || grid->cells.empty()) throw Error("no four lines of the grid form a cell");
  const fs::path list = work / "poses.csv", room = work / "room.lf", log = work / "log.txt";
  write_file_atomically(list, frame_list_text(shrunk_frames(input.frames, size, work / "frames")));
  std::vector<std::string> pack{"pack", "--frames", list.string(), "--out", room.string()};
  const double tolerance_mm =
      line_tolerance_needed_mm(input.frames, input.lines, input.tolerance).value_or(0.0);
  if (tolerance_mm > 0.0) {
    pack.insert(pack.end(), {"--line-tolerance-mm", fmt::format("{}", tolerance_mm)});
  }
  if (const auto& same_m = input.tolerance.same_station_m) {
    pack.insert(pack.end(), {"--same-station-mm", fmt::format("{}", *same_m * 1e3)});
  }
  run(program_in(programs, "raywalk-build-lf"), pack, log);
  progress->advance();
  run(program_in(programs, "raywalk-render"),
      {"connect-error", room.string(), "--generation", kGeneration, "--viewpoints", kViewpoints},
      log);
  progress->advance();
  for (ConnectionErrorMeasurement& measured : read_connection_errors(room)) {
    if (measured.generation == kGeneration) return measured;
  }
  throw Error("raywalk-render connect-error measured nothing");
}

}  // namespace

ConnectionBeforeAfter measure_connection(const ConnectionInput& before,
                                         const ConnectionInput& after,
                                         const std::optional<fs::path>& programs,
                                         const fs::path& work) {
  ConnectionBeforeAfter result;
  try {
    for (const char* name : {"raywalk-build-lf", "raywalk-render"}) program_in(programs, name);
    const PanoramaSize size = panorama_size_of(before.frames.at(0).file);
    result.width_px = std::min(size.width, kWidestPicture);
    Progress progress("measuring the connection error", 4, "runs");
    const ConnectionErrorMeasurement first = measure(before, size, programs, work, &progress);
    const ConnectionErrorMeasurement second = measure(after, size, programs, work, &progress);
    for (std::size_t i = 0; i < std::min(first.rows.size(), second.rows.size()); ++i) {
      result.rows.push_back({.k_deg = first.rows[i].k_deg,
                             .before = first.rows[i].e_connect,
                             .after = second.rows[i].e_connect});
    }
  } catch (const Error& e) {
    result.rows.clear();
    result.note = e.what();
  }
  return result;
}

}  // namespace raywalk::calibrate
