// What of Hdf5File creates and writes.
#include <fmt/format.h>

#include <functional>
#include <utility>

#include "core/base/error.h"
#include "core/room/hdf5_calls.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

using hdf5::check;
using hdf5::Id;

constexpr unsigned kDeflateLevel = 4;  // higher ones save a hundredth

// Creates a dataset that is contiguous or, with a shape of chunks, in these, through the filters
// that `add_filters` adds to its properties.
Id created(hid_t file, const std::string& name, hid_t type, const Shape& shape,
           const Shape& chunk = {}, const std::function<void(hid_t)>& add_filters = {}) {
  const Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  // Without times, files of the same content have the same bytes.
  check(H5Pset_obj_track_times(properties, false));
  if (chunk.empty()) {
    check(H5Pset_layout(properties, H5D_CONTIGUOUS));
    check(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY));
    check(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER));
  } else {
    const std::vector<hsize_t> dims = hdf5::dims_of(chunk);
    check(H5Pset_chunk(properties, static_cast<int>(dims.size()), dims.data()));
    add_filters(properties);
  }
  return {H5Dcreate2(file, name.c_str(), type, hdf5::space_of(shape), H5P_DEFAULT, properties,
                     H5P_DEFAULT),
          H5Dclose};
}

void write_whole(hid_t file, const std::string& name, hid_t type, const Shape& shape,
                 const void* values) {
  check(H5Dwrite(created(file, name, type, shape), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
}

void write_scalar(hid_t file, const std::string& where, const std::string& name, hid_t type,
                  const void* value) {
  const Id scalar(H5Screate(H5S_SCALAR), H5Sclose);
  const Id attribute(H5Acreate_by_name(file, where.c_str(), name.c_str(), type, scalar, H5P_DEFAULT,
                                       H5P_DEFAULT, H5P_DEFAULT),
                     H5Aclose);
  check(H5Awrite(attribute, type, value));
}

Id text_type(std::size_t length) {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  check(H5Tset_size(type, length));
  check(H5Tset_strpad(type, H5T_STR_NULLPAD));
  check(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

}  // namespace

// HDF5 1.10 crashes when it closes a file whose buffers cannot be written (disk full), even at
// process exit, so after a failed write the file is never closed.
template <typename Call>
auto Hdf5File::writing(const std::string& what, const Call& call) {
  try {
    return hdf5::guarded(path_, "cannot " + what, call);
  } catch (const Error&) {
    file_ = -1;
    throw;
  }
}

Hdf5File Hdf5File::create(const std::filesystem::path& path) {
  Hdf5File file(path);
  hdf5::guarded(path, "cannot create the file", [&] {
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // The format of HDF5 1.10: its metadata have checksums, so that damage is detected.
    check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
    // Datasets are memory-mapped, so their numbers must be aligned in the file.
    check(H5Pset_alignment(access, 1, 8));
    const Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(creation, false));
    file.file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
    if (file.file_ < 0) throw hdf5::Failure();
  });
  return file;
}

void Hdf5File::write_format(const std::string& format, int version) {
  write_attribute("/", "format", format);
  writing("write attribute format_version",
          [&] { write_scalar(file_, "/", "format_version", H5T_STD_I32LE, &version); });
}

void Hdf5File::write_attribute(const std::string& where, const std::string& name,
                               const std::string& text) {
  writing("write attribute " + name,
          [&] { write_scalar(file_, where, name, text_type(text.size()), text.data()); });
}

template <typename T>
void Hdf5File::write(const std::string& name, const std::vector<T>& values, Shape shape) {
  if (shape.empty()) shape = {values.size()};
  writing(fmt::format("write dataset '{}'", name), [&] {
    write_whole(file_, name, hdf5::type_of(hdf5::kElementOf<T>), shape, values.data());
  });
}
template void Hdf5File::write(const std::string&, const std::vector<std::int32_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<std::uint64_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<double>&, Shape);

void Hdf5File::write_strings(const std::string& name, const std::vector<std::string>& values) {
  std::string all;
  for (const std::string& value : values) all += value;
  writing(fmt::format("write dataset '{}'", name), [&] {
    write_whole(file_, name, text_type(values.front().size()), {values.size()}, all.data());
  });
}

void Hdf5File::create_contiguous(const std::string& name, ElementType type, const Shape& shape) {
  writing(fmt::format("create dataset '{}'", name),
          [&] { created(file_, name, hdf5::type_of(type), shape); });
}

void Hdf5File::create_deflated(const std::string& name, ElementType type, const Shape& shape) {
  writing(fmt::format("create dataset '{}'", name), [&] {
    created(file_, name, hdf5::type_of(type), shape, hdf5::slab_of(shape), [](hid_t properties) {
      check(H5Pset_shuffle(properties));
      check(H5Pset_deflate(properties, kDeflateLevel));
    });
  });
}

void Hdf5File::create_encoded(const std::string& name, const Shape& shape, const Shape& chunk,
                              int filter, const std::vector<unsigned>& filter_values) {
  writing(fmt::format("create dataset '{}'", name), [&] {
    created(file_, name, H5T_STD_U8LE, shape, chunk, [&](hid_t properties) {
      // HDF5 requires a filter that is not optional to be there where the dataset is created.
      check(H5Pset_filter(properties, filter, H5Z_FLAG_OPTIONAL, filter_values.size(),
                          filter_values.data()));
    });
  });
}

void Hdf5File::write_slab(const std::string& name, std::size_t index, const void* values) {
  writing("write", [&] {
    const hdf5::Dataset dataset(file_, name);
    const Shape& shape = dataset.shape;
    check(H5Dwrite(dataset.id, dataset.type, hdf5::space_of(hdf5::slab_of(shape)),
                   hdf5::slab_space(shape, index), H5P_DEFAULT, values));
  });
}

FilePlace Hdf5File::write_chunk(const std::string& name, const Shape& start,
                                std::span<const std::uint8_t> encoded) {
  return writing("write", [&] {
    const hdf5::Dataset dataset(file_, name);
    const std::vector<hsize_t> place = hdf5::dims_of(start);
    unsigned skipped_filters = 0;
    haddr_t begin = HADDR_UNDEF;
    hsize_t bytes = 0;
    check(H5Dwrite_chunk(dataset.id, H5P_DEFAULT, 0, place.data(), encoded.size(), encoded.data()));
    check(H5Dget_chunk_info_by_coord(dataset.id, place.data(), &skipped_filters, &begin, &bytes));
    return FilePlace{begin, bytes};
  });
}

void Hdf5File::close() {
  writing("write", [&] {
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));
    check(H5Fclose(std::exchange(file_, -1)));
  });
}

}  // namespace raywalk
