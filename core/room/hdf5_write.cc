// What Hdf5File writes.
#include <fmt/format.h>

#include <utility>

#include "core/room/hdf5_calls.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

using namespace hdf5;  // NOLINT(google-build-using-namespace): its functions are for this file

constexpr unsigned kDeflateLevel = 4;  // higher ones save a hundredth

// Properties of a dataset to be created. Without times, files of the same content have the same
// bytes.
Id new_properties() {
  Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  check(H5Pset_obj_track_times(properties, false));
  return properties;
}

Id contiguous() {
  Id properties = new_properties();
  check(H5Pset_layout(properties, H5D_CONTIGUOUS));
  check(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY));
  check(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER));
  return properties;
}

Id in_chunks(const Shape& chunk) {
  Id properties = new_properties();
  check(H5Pset_chunk(properties, static_cast<int>(chunk.size()), dims_of(chunk).data()));
  return properties;
}

Id created(hid_t file, const std::string& name, hid_t type, const Shape& shape, hid_t properties) {
  return {
      H5Dcreate2(file, name.c_str(), type, space_of(shape), H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose};
}

void write_whole(hid_t file, const std::string& name, hid_t type, const Shape& shape,
                 const void* values) {
  check(H5Dwrite(created(file, name, type, shape, contiguous()), type, H5S_ALL, H5S_ALL,
                 H5P_DEFAULT, values));
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
auto Hdf5File::write_guarded(const std::string& what, const Call& call) {
  try {
    return guarded(what, call);
  } catch (const Error&) {
    file_ = -1;
    throw;
  }
}

void Hdf5File::write_format(const std::string& format, int version) {
  write_attribute("/", "format", format);
  write_guarded("cannot write attribute format_version",
                [&] { write_scalar(file_, "/", "format_version", H5T_STD_I32LE, &version); });
}

void Hdf5File::write_attribute(const std::string& where, const std::string& name,
                               const std::string& text) {
  write_guarded("cannot write attribute " + name,
                [&] { write_scalar(file_, where, name, text_type(text.size()), text.data()); });
}

template <typename T>
void Hdf5File::write(const std::string& name, const std::vector<T>& values, Shape shape) {
  if (shape.empty()) shape = {values.size()};
  write_guarded(fmt::format("cannot write dataset '{}'", name),
                [&] { write_whole(file_, name, type_of(kElementOf<T>), shape, values.data()); });
}
template void Hdf5File::write(const std::string&, const std::vector<std::int32_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<std::uint64_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<double>&, Shape);

void Hdf5File::write_strings(const std::string& name, const std::vector<std::string>& values) {
  std::string all;
  for (const std::string& value : values) all += value;
  write_guarded(fmt::format("cannot write dataset '{}'", name), [&] {
    write_whole(file_, name, text_type(values.front().size()), {values.size()}, all.data());
  });
}

void Hdf5File::create_contiguous(const std::string& name, ElementType type, const Shape& shape) {
  write_guarded(fmt::format("cannot create dataset '{}'", name),
                [&] { created(file_, name, type_of(type), shape, contiguous()); });
}

void Hdf5File::create_deflated(const std::string& name, ElementType type, const Shape& shape) {
  write_guarded(fmt::format("cannot create dataset '{}'", name), [&] {
    const Id properties = in_chunks(slab_of(shape));
    check(H5Pset_shuffle(properties));
    check(H5Pset_deflate(properties, kDeflateLevel));
    created(file_, name, type_of(type), shape, properties);
  });
}

void Hdf5File::write_slab(const std::string& name, std::size_t index, const void* values) {
  write_guarded("cannot write", [&] {
    const Id dataset = opened(file_, name);
    const Shape shape = shape_of_dataset(dataset);
    check(H5Dwrite(dataset, stored_type_of(dataset), space_of(slab_of(shape)),
                   selected(shape, index), H5P_DEFAULT, values));
  });
}

void Hdf5File::create_encoded(const std::string& name, const Shape& shape,
                              const EncodedChunks& chunks) {
  write_guarded(fmt::format("cannot create dataset '{}'", name), [&] {
    const Id properties = in_chunks(chunks.chunk);
    // HDF5 requires a filter that is not optional to be there where the dataset is created.
    check(H5Pset_filter(properties, chunks.filter, H5Z_FLAG_OPTIONAL, chunks.values.size(),
                        chunks.values.data()));
    created(file_, name, H5T_STD_U8LE, shape, properties);
  });
}

FilePlace Hdf5File::write_chunk(const std::string& name, const Shape& start,
                                std::span<const std::uint8_t> encoded) {
  return write_guarded("cannot write", [&] {
    const Id dataset = opened(file_, name);
    const std::vector<hsize_t> place = dims_of(start);
    unsigned skipped_filters = 0;
    haddr_t begin = HADDR_UNDEF;
    hsize_t bytes = 0;
    check(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, place.data(), encoded.size(), encoded.data()));
    check(H5Dget_chunk_info_by_coord(dataset, place.data(), &skipped_filters, &begin, &bytes));
    return FilePlace{begin, bytes};
  });
}

void Hdf5File::close() {
  write_guarded("cannot write", [&] {
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));
    check(H5Fclose(std::exchange(file_, -1)));
  });
}

}  // namespace raywalk
