// Values in a row of bytes, for results that this machine's processes hand to each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace raywalk {

class PackedWriter {
 public:
  template <typename T>
  void add(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>,
                  "bytes between members have no value");
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  // The number of values, then the values, which have no bytes between members.
  template <typename T>
  void add_all(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add(static_cast<std::uint64_t>(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// Reads what a PackedWriter wrote, in the same order. Throws Error past the end.
class PackedReader {
 public:
  // `bytes` must outlive the reader.
  explicit PackedReader(std::string_view bytes) : bytes_(bytes) {}

  bool at_end() const { return bytes_.empty(); }
  template <typename T>
  T next() {
    T value;
    take(&value, sizeof(T));
    return value;
  }
  template <typename T>
  std::vector<T> next_all() {
    const auto count = next<std::uint64_t>();
    if (count > bytes_.size() / sizeof(T)) throw_truncated();
    std::vector<T> values(count);
    take(values.data(), values.size() * sizeof(T));
    return values;
  }

 private:
  [[noreturn]] static void throw_truncated() {
    throw Error("an unfinished result is truncated; remove it and run the command again");
  }
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) throw_truncated();
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
};

}  // namespace raywalk
