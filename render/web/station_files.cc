#include "render/web/station_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "render/web/inverse_file.h"
#include "render/web/station_distances.h"
#include "render/web/station_pictures.h"
#include "render/web/web_jpeg.h"
#include "render/web/web_manifest.h"
#include "render/web/web_plan.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

void write_pictures(const fs::path& folder, const std::string& name, const cv::Mat& picture) {
  write_jpeg(folder / (name + ".jpg"), picture);
  const int width = coarse_width_of(picture.cols);
  cv::Mat coarse;
  cv::resize(picture, coarse, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  write_jpeg(folder / (name + "-coarse.jpg"), coarse);
}

fs::path inverse_path(const fs::path& folder, int index) {
  return folder / (station_name(index) + ".inverse");
}

// The distances wait in their files as they are, because the step of their values is that of the
// largest of all.
void write_whole(const fs::path& file, const InverseMap& distances) {
  write_file_atomically(file, std::as_bytes(distances.values()));
}

InverseMap read_whole(const fs::path& file, int width) {
  const std::string bytes = read_file(file);
  InverseMap distances({width, width / 2});
  if (bytes.size() != distances.values().size_bytes()) {
    throw Error(file.string() + " was changed while the room was exported; export it again");
  }
  std::ranges::copy(std::as_bytes(std::span(bytes)),
                    std::as_writable_bytes(distances.values()).begin());
  return distances;
}

void encode_distances(const fs::path& folder, int stations, int width, double step_per_m) {
  Progress progress("encoding", stations, "distance maps");
  for (int i = 0; i < stations; ++i) {
    throw_if_interrupted();
    const fs::path file = inverse_path(folder, i);
    write_file_atomically(file, encode_inverse(read_whole(file, width), step_per_m));
    progress.advance();
  }
}

int stations_of(const Grid& grid) {
  int count = 0;
  for (const Line& line : grid.lines) count += static_cast<int>(line.stations.size());
  return count;
}

}  // namespace

double write_stations(const Room& room, const ViewOptions& options, int distance_width,
                      const fs::path& folder) {
  StationPictures pictures(room, options);
  StationDistances distances(room, distance_width);
  const int stations = stations_of(room.grid());
  float largest_per_m = 0.0F;
  int done = 0;
  try {
    Progress progress("exporting", stations, "stations");
    for (std::size_t line = 0; line < room.grid().lines.size(); ++line) {
      const auto of_line = static_cast<int>(room.grid().lines[line].stations.size());
      for (int station = 0; station < of_line; ++station, ++done) {
        throw_if_interrupted();
        const auto index = static_cast<int>(line);
        const InverseMap seen = distances.seen_from(index, station);
        largest_per_m = std::max(largest_per_m, std::ranges::max(seen.values()));
        write_whole(inverse_path(folder, done), seen);
        write_pictures(folder, station_name(done), pictures.picture_of(index, station, seen));
        progress.advance();
      }
    }
    const double step_per_m =
        (largest_per_m > 0.0F ? double{largest_per_m} : 1.0) / kLargestInverseValue;
    encode_distances(folder, stations, distance_width, step_per_m);
    return step_per_m;
  } catch (const Interrupted&) {
    throw Interrupted(
        fmt::format("interrupted after {} of {} stations; nothing was exported", done, stations));
  }
}

}  // namespace raywalk::render
