#include "build_lf/cluster/room_scale.h"

#include <string>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "core/base/error.h"
#include "core/files/csv.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

double megapixels(PanoramaSize size) { return 1e-6 * size.width * size.height; }

int rows_of(const fs::path& file, const std::vector<std::string>& required,
            const std::vector<std::string>& optional) {
  const CsvTable table = CsvTable::read(file, required, optional);
  if (table.rows() == 0) throw Error(file.string() + ": has no rows");
  return static_cast<int>(table.rows());
}

}  // namespace

double RoomScale::panorama_mpx() const { return megapixels(panorama); }

double RoomScale::map_mpx() const { return megapixels(size_of_maps(panorama)); }

RoomScale scale_of(const fs::path& frames, const GridTolerance& tolerance,
                   const std::optional<fs::path>& truth, const std::optional<fs::path>& walk) {
  if (frames == "-") {
    throw UsageError(
        "--frames -: every machine has to read the list; give a file that all of them see");
  }
  const std::vector<Frame> list = read_frame_list(frames);
  std::vector<StationPose> poses;
  poses.reserve(list.size());
  for (const Frame& frame : list) {
    poses.push_back({frame.file, frame.position_m, frame.where, frame.line});
  }
  const Grid grid = find_grid(poses, tolerance);
  RoomScale scale;
  scale.panorama = panorama_size_of(list.front().path);
  scale.lines = static_cast<int>(grid.lines.size());
  scale.stations = static_cast<int>(list.size());
  scale.cells = static_cast<int>(grid.cells.size());
  scale.maps = count_of_maps(grid);
  if (truth) scale.truth_views = rows_of(*truth, {"file", "x", "y", "z"}, {"mask", "distance"});
  if (walk) {
    scale.walk_views = rows_of(*walk, {"name", "x", "z"}, {"y", "yaw", "pitch", "roll", "time"});
  }
  return scale;
}

}  // namespace raywalk::build_lf
