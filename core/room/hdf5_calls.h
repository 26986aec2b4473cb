// How hdf5_file.cc and hdf5_writing.cc call HDF5: one thread at a time, with identifiers that close
// themselves and failures that become Errors.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/room/hdf5_file.h"

namespace raywalk::hdf5 {

// A call of HDF5 failed; guarded() knows why.
struct Failure {};

inline void check(herr_t status) {
  if (status < 0) throw Failure();
}

// Owns an identifier of HDF5.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw Failure();
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

// Held while HDF5 is used; what it says of failures is kept from then on.
std::unique_lock<std::mutex> locked();
[[noreturn]] void throw_failure(const std::filesystem::path& file, const std::string& what);

// What `call` returns. Throws Error "<file>: <what>: <HDF5's innermost reason>" where HDF5 fails.
template <typename Call>
auto guarded(const std::filesystem::path& file, const std::string& what, const Call& call) {
  const auto lock = locked();
  try {
    return call();
  } catch (const Failure&) {
    throw_failure(file, what);
  }
}

// As stored; Raywalk's machines are little-endian.
hid_t type_of(ElementType type);
template <typename T>
constexpr ElementType kElementOf = std::is_same_v<T, double>         ? ElementType::kFloat64
                                   : std::is_same_v<T, std::int32_t> ? ElementType::kInt32
                                                                     : ElementType::kUint64;

// An open dataset, and how it is stored.
struct Dataset {
  Dataset(hid_t file, const std::string& name);
  Id id, type, properties;
  Shape shape;
};

std::vector<hsize_t> dims_of(const Shape& shape);
Id space_of(const Shape& shape);
// The shape of one index of the first dimension, and its place among a file's values.
Shape slab_of(Shape shape);
Id slab_space(const Shape& shape, std::size_t index);

}  // namespace raywalk::hdf5
