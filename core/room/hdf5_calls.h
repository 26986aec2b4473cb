// Of hdf5_file.cc and hdf5_write.cc only: calls of HDF5 whose failures are exceptions.
#pragma once

#include <fmt/format.h>
#include <hdf5.h>

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/room/hdf5_file.h"

namespace raywalk::hdf5 {

// Held while HDF5 is used.
std::recursive_mutex& library();
// Before HDF5 is used in a thread.
void prepare_library();
// What the last call that failed means, and what to do.
std::string meaning_of_failure();

// A call of HDF5 failed; last_reason says why.
struct Hdf5Failure {};

inline void check(herr_t status) {
  if (status < 0) throw Hdf5Failure();
}

// Owns an identifier of HDF5.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw Hdf5Failure();
  }
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Id& operator=(Id&&) = delete;
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): as HDF5 takes it

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// As stored; Raywalk's machines are little-endian.
inline hid_t type_of(ElementType type) {
  switch (type) {
    case ElementType::kUint8:
      return H5T_STD_U8LE;
    case ElementType::kInt32:
      return H5T_STD_I32LE;
    case ElementType::kUint64:
      return H5T_STD_U64LE;
    case ElementType::kFloat32:
      return H5T_IEEE_F32LE;
    case ElementType::kFloat64:
      break;
  }
  return H5T_IEEE_F64LE;
}

template <typename T>
constexpr ElementType kElementOf = std::is_same_v<T, double>         ? ElementType::kFloat64
                                   : std::is_same_v<T, std::int32_t> ? ElementType::kInt32
                                                                     : ElementType::kUint64;

inline std::vector<hsize_t> dims_of(const Shape& shape) { return {shape.begin(), shape.end()}; }

inline Id space_of(const Shape& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), dims_of(shape).data(), nullptr),
          H5Sclose};
}

inline Id opened(hid_t file, const std::string& dataset) {
  return {H5Dopen2(file, dataset.c_str(), H5P_DEFAULT), H5Dclose};
}

inline Id stored_type_of(hid_t dataset) { return {H5Dget_type(dataset), H5Tclose}; }

inline Id properties_of(hid_t dataset) { return {H5Dget_create_plist(dataset), H5Pclose}; }

inline Shape shape_of_dataset(hid_t dataset) {
  const Id space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  check(rank);
  std::vector<hsize_t> dims(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space, dims.data(), nullptr));
  return {dims.begin(), dims.end()};
}

// Of all values; none where that is no number of bytes.
inline std::optional<std::size_t> bytes_of(const Shape& shape, std::size_t bytes) {
  for (const std::size_t extent : shape) {
    if (extent != 0 && bytes > std::numeric_limits<std::size_t>::max() / 2 / extent) return {};
    bytes *= extent;
  }
  return bytes;
}

// The shape of one index of the first dimension.
inline Shape slab_of(Shape shape) {
  shape.front() = 1;
  return shape;
}

// One index of the first dimension of a file's values.
inline Id selected(const Shape& shape, std::size_t index) {
  std::vector<hsize_t> start(shape.size(), 0);
  start.front() = index;
  Id space = space_of(shape);
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr,
                            dims_of(slab_of(shape)).data(), nullptr));
  return space;
}

}  // namespace raywalk::hdf5

namespace raywalk {

template <typename Call>
auto Hdf5File::guarded(const std::string& what, const Call& call) const {
  const std::lock_guard lock(hdf5::library());
  hdf5::prepare_library();
  try {
    return call();
  } catch (const hdf5::Hdf5Failure&) {
    throw Error(fmt::format("{}: {}: {}", path_.string(), what, hdf5::meaning_of_failure()));
  }
}

}  // namespace raywalk
