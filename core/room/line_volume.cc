#include "core/room/line_volume.h"

#include <array>
#include <numeric>

#include "core/room/hdf5_file.h"

namespace raywalk {
LineVolume LineVolume::open(const std::filesystem::path& file, int stations,
                            PanoramaSize panorama) {
  LineVolume volume;
  bool masked = false;
  {
    const Hdf5File hdf5 = Hdf5File::open(file);
    hdf5.require_format(kLineVolumeFormat);
    masked = hdf5.has_dataset("valid_rows");
    if (hdf5.has_dataset("tiles")) volume.tiles_ = TiledRays::open(hdf5, stations, panorama);
  }
  const auto count = static_cast<size_t>(stations);
  const auto width = static_cast<size_t>(panorama.width);
  volume.stations_in_file_ = stations;
  volume.stored_.resize(count);
  std::iota(volume.stored_.begin(), volume.stored_.end(), 0);
  volume.panorama_ = panorama;
  if (volume.tiles_) {
    volume.form_ = volume.tiles_->form();
  } else {
    volume.rays_ =
        std::make_shared<MappedDataset>(MappedDataset::open(file, "rays", ElementType::kUint8));
    volume.rays_->expect_scattered_reads();
    require_shape(volume.rays_->shape(),
                  std::array{count, width, static_cast<size_t>(panorama.height), size_t{3}}, "rays",
                  file);
  }
  if (masked) {
    volume.valid_rows_ = std::make_shared<MappedDataset>(
        MappedDataset::open(file, "valid_rows", ElementType::kInt32));
    require_shape(volume.valid_rows_->shape(), std::array{count, width, size_t{2}}, "valid_rows",
                  file);
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
