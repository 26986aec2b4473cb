// Datasets of Hdf5File that are stored in chunks.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk {

Hdf5Handle Hdf5File::create_chunked(const std::string& name, hid_t type,
                                    std::span<const std::size_t> shape,
                                    const std::function<bool(hid_t)>& add_filters) const {
  const std::string what = fmt::format("cannot create dataset '{}'", name);
  const std::vector<hsize_t> dims = dims_of(shape);
  std::vector<hsize_t> chunk = dims;
  chunk[0] = 1;
  const Hdf5Handle space = checked(
      H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose, what);
  const Hdf5Handle properties = checked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
  H5Pset_obj_track_times(properties.get(), false);
  if (H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data()) < 0 ||
      !add_filters(properties.get())) {
    fail(what);
  }
  return checked(H5Dcreate2(file_.get(), name.c_str(), type, space.get(), H5P_DEFAULT,
                            properties.get(), H5P_DEFAULT),
                 H5Dclose, what);
}

Hdf5Handle Hdf5File::create_filtered(const std::string& name, hid_t type,
                                     std::span<const std::size_t> shape, int filter) {
  // The filter is told the size of a decoded chunk. HDF5 requires a filter that is not optional to
  // be there where the dataset is created.
  std::uint64_t bytes = H5Tget_size(type);
  for (const std::size_t extent : shape.subspan(1)) bytes *= extent;
  const std::array<unsigned, 2> values{static_cast<unsigned>(bytes),
                                       static_cast<unsigned>(bytes >> 32U)};
  return create_chunked(name, type, shape, [&](hid_t properties) {
    return H5Pset_filter(properties, filter, H5Z_FLAG_OPTIONAL, values.size(), values.data()) >= 0;
  });
}

Hdf5Handle Hdf5File::create_deflated(const std::string& name, hid_t type,
                                     std::span<const std::size_t> shape) {
  constexpr unsigned kLevel = 4;  // higher ones save a hundredth
  return create_chunked(name, type, shape, [](hid_t properties) {
    return H5Pset_shuffle(properties) >= 0 && H5Pset_deflate(properties, kLevel) >= 0;
  });
}

bool Hdf5File::is_chunked(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  const Hdf5Handle properties(H5Dget_create_plist(dataset.get()), H5Pclose);
  return properties.get() >= 0 && H5Pget_layout(properties.get()) == H5D_CHUNKED;
}

std::vector<Hdf5File::ChunkPlace> Hdf5File::deflated_chunks(const std::string& name,
                                                            hid_t type) const {
  const std::vector<std::size_t> shape = shape_of(name);
  const Hdf5Handle dataset = open_dataset(name);
  const Hdf5Handle stored(H5Dget_type(dataset.get()), H5Tclose);
  const Hdf5Handle properties(H5Dget_create_plist(dataset.get()), H5Pclose);
  const auto filter = [&](unsigned index) {
    std::size_t values = 0;
    unsigned flags = 0, config = 0;
    return H5Pget_filter2(properties.get(), index, &flags, &values, nullptr, 0, nullptr, &config);
  };
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  bool usual = stored.get() >= 0 && H5Tequal(stored.get(), type) > 0 && properties.get() >= 0 &&
               H5Pget_layout(properties.get()) == H5D_CHUNKED &&
               H5Pget_chunk(properties.get(), H5S_MAX_RANK, chunk.data()) ==
                   static_cast<int>(shape.size()) &&
               chunk[0] == 1 && std::equal(shape.begin() + 1, shape.end(), chunk.begin() + 1) &&
               H5Pget_nfilters(properties.get()) == 2 && filter(0) == H5Z_FILTER_SHUFFLE &&
               filter(1) == H5Z_FILTER_DEFLATE;
  std::vector<ChunkPlace> places;
  for (std::size_t i = 0; usual && i < shape.front(); ++i) {
    std::array<hsize_t, H5S_MAX_RANK> place{};
    place[0] = i;
    unsigned skipped = 0;
    haddr_t begin = HADDR_UNDEF;
    hsize_t bytes = 0;
    usual =
        H5Dget_chunk_info_by_coord(dataset.get(), place.data(), &skipped, &begin, &bytes) >= 0 &&
        begin != HADDR_UNDEF && (skipped & 1U) == 0;
    places.push_back({begin, bytes, (skipped & 2U) == 0});
  }
  if (usual) return places;
  throw Error(
      fmt::format("{}: dataset '{}' is neither contiguous nor compressed as Raywalk does; "
                  "write it again",
                  path_.string(), name));
}

std::uint64_t Hdf5File::write_chunk(const Hdf5Handle& dataset, std::size_t index,
                                    std::span<const std::uint8_t> encoded) {
  prepare_library_for_this_thread();
  std::array<hsize_t, H5S_MAX_RANK> place{};
  place[0] = index;
  unsigned filters_skipped = 0;
  haddr_t begin = HADDR_UNDEF;
  hsize_t bytes = 0;
  if (H5Dwrite_chunk(dataset.get(), H5P_DEFAULT, 0, place.data(), encoded.size(), encoded.data()) <
          0 ||
      H5Dget_chunk_info_by_coord(dataset.get(), place.data(), &filters_skipped, &begin, &bytes) <
          0 ||
      begin == HADDR_UNDEF || bytes != encoded.size()) {
    fail_to_write("cannot write");
  }
  return begin;
}

}  // namespace raywalk
