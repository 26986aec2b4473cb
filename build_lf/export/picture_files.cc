#include "build_lf/export/picture_files.h"

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::build_lf {

std::string picture_name(const ExportedStation& station, bool jpeg) {
  return station.name + (jpeg ? ".jpg" : ".png");
}

std::string panorama_file(const ExportedStation& station, bool jpeg) {
  return "images/" + picture_name(station, jpeg);
}

std::string mask_file(const ExportedStation& station) { return "masks/" + station.name + ".png"; }

void write_panoramas(const Room& room, const std::vector<ExportedStation>& stations,
                     const ExportOptions& options, const std::filesystem::path& directory) {
  const bool masked = has_unusable_pixels(room);
  make_directories(directory / "images");
  if (masked) make_directories(directory / "masks");
  Progress progress("Writing panoramas", static_cast<std::int64_t>(stations.size()), "panoramas");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ExportedStation& station = stations[static_cast<std::size_t>(i)];
      write_image(directory / panorama_file(station, options.jpeg),
                  station_picture(room, station, options.gains));
      if (masked) write_image(directory / mask_file(station), station_mask(room, station));
      progress.advance();
    }
  });
}

}  // namespace raywalk::build_lf
