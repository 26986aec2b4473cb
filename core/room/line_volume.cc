#include "core/room/line_volume.h"

#include <numeric>

#include "core/room/hdf5_file.h"

namespace raywalk {

LineVolume LineVolume::open(const std::filesystem::path& file, int stations,
                            PanoramaSize panorama) {
  const Hdf5File hdf5 = Hdf5File::open(file);
  hdf5.require_format(kLineVolumeFormat);
  LineVolume volume;
  volume.stations_in_file_ = stations;
  volume.stored_.resize(static_cast<size_t>(stations));
  std::iota(volume.stored_.begin(), volume.stored_.end(), 0);
  volume.panorama_ = panorama;
  const auto count = static_cast<size_t>(stations);
  const auto width = static_cast<size_t>(panorama.width);
  hdf5.require_shape("rays", {count, width, static_cast<size_t>(panorama.height), 3});
  if (hdf5.has_dataset("tiles")) {
    volume.tiles_ = std::make_shared<TiledRays>(hdf5, stations, panorama);
    volume.form_ = volume.tiles_->form();
  } else {
    volume.rays_ = std::make_shared<MappedDataset>(hdf5, "rays", ElementType::kUint8);
    volume.rays_->expect_scattered_reads();
  }
  if (hdf5.has_dataset("valid_rows")) {
    hdf5.require_shape("valid_rows", {count, width, 2});
    volume.valid_rows_ = std::make_shared<MappedDataset>(hdf5, "valid_rows", ElementType::kInt32);
  }
  return volume;
}

LineVolume LineVolume::subset(std::span<const int> stations) const {
  LineVolume part = *this;
  part.stored_.clear();
  for (const int station : stations) {
    part.stored_.push_back(stored_[static_cast<size_t>(station)]);
  }
  return part;
}

}  // namespace raywalk
