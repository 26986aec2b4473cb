#include "core/room/line_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numeric>

#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

void require_shape(const MappedDataset& dataset, const std::vector<std::size_t>& expected,
                   const char* name, const std::filesystem::path& file) {
  if (dataset.shape() == expected) return;
  throw Error(fmt::format("{}: dataset '{}' has the shape [{}], the manifest says [{}]",
                          file.string(), name, fmt::join(dataset.shape(), ", "),
                          fmt::join(expected, ", ")));
}

}  // namespace

LineVolume LineVolume::open(const std::filesystem::path& file, int stations,
                            PanoramaSize panorama) {
  bool masked = false;
  {
    const Hdf5File hdf5 = Hdf5File::open(file);
    hdf5.require_format(kLineVolumeFormat);
    masked = hdf5.has_dataset("valid_rows");
  }
  const auto count = static_cast<size_t>(stations);
  const auto width = static_cast<size_t>(panorama.width);
  LineVolume volume;
  volume.rays_ =
      std::make_shared<MappedDataset>(MappedDataset::open(file, "rays", ElementType::kUint8));
  volume.rays_->expect_scattered_reads();
  volume.stored_.resize(count);
  std::iota(volume.stored_.begin(), volume.stored_.end(), 0);
  volume.panorama_ = panorama;
  volume.polar_part_ = PolarPart(panorama);
  volume.stored_columns_ = width;
  volume.layout_ = volume.polar_part_.layout_without();
  const size_t with_polar_part = width + static_cast<size_t>(volume.polar_part_.columns());
  if (volume.rays_->shape().size() == 4 && volume.rays_->shape()[1] == with_polar_part) {
    volume.stored_columns_ = with_polar_part;
    volume.layout_ = volume.polar_part_.layout();
  }
  require_shape(*volume.rays_,
                {count, volume.stored_columns_, static_cast<size_t>(panorama.height), 3}, "rays",
                file);
  if (masked) {
    volume.valid_rows_ = std::make_shared<MappedDataset>(
        MappedDataset::open(file, "valid_rows", ElementType::kInt32));
    require_shape(*volume.valid_rows_, {count, width, 2}, "valid_rows", file);
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
