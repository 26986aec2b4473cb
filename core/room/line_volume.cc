#include "core/room/line_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk {

LineVolume LineVolume::open(const std::filesystem::path& file, int stations,
                            PanoramaSize panorama) {
  Hdf5File::open(file).require_format(kLineVolumeFormat);
  LineVolume volume;
  volume.rays_ = MappedDataset::open(file, "rays", ElementType::kUint8);
  volume.rays_.expect_scattered_reads();
  volume.stations_ = stations;
  volume.panorama_ = panorama;
  const std::vector<std::size_t> expected{static_cast<size_t>(stations),
                                          static_cast<size_t>(panorama.width),
                                          static_cast<size_t>(panorama.height), 3};
  if (volume.rays_.shape() != expected) {
    throw Error(fmt::format("{}: dataset 'rays' has the shape [{}], the manifest says [{}]",
                            file.string(), fmt::join(volume.rays_.shape(), ", "),
                            fmt::join(expected, ", ")));
  }
  return volume;
}

}  // namespace raywalk
