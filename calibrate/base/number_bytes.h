// Numbers as bytes, for files that a program keeps for itself between two of its runs: exact, in
// the order of bytes of this machine.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/base/error.h"

namespace raywalk::calibrate {

class NumberWriter {
 public:
  template <typename Number>
  void number(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), &value, sizeof(Number));
    bytes_.append(raw.data(), raw.size());
  }
  void size(std::size_t value) { number(static_cast<std::uint64_t>(value)); }
  // All elements of a matrix or an array of fixed size, as doubles.
  template <typename Matrix>
  void matrix(const Matrix& values) {
    for (const double value : values.reshaped()) number(value);
  }
  void text(const std::string& value) {
    size(value.size());
    bytes_ += value;
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_{};
};

// Reads what NumberWriter wrote, in the same order. Every function throws Error with the message
// given if the bytes cannot be that.
class NumberReader {
 public:
  NumberReader(std::string_view bytes, std::string damaged)
      : bytes_(bytes), damaged_(std::move(damaged)) {}

  template <typename Number>
  Number number() {
    Number value{};
    std::memcpy(&value, take(sizeof(Number)).data(), sizeof(Number));
    return value;
  }
  // Of things that take at least a byte each, so that a wrong number cannot fill the memory.
  std::size_t size() {
    const auto value = number<std::uint64_t>();
    if (value > bytes_.size()) fail();
    return static_cast<std::size_t>(value);
  }
  // An std::int32_t from 0 to count - 1.
  int index(std::size_t count) {
    const auto value = number<std::int32_t>();
    if (value < 0 || static_cast<std::size_t>(value) >= count) fail();
    return value;
  }
  template <typename Matrix>
  Matrix matrix() {
    Matrix values;
    for (double& value : values.reshaped()) value = number<double>();
    return values;
  }
  std::string text() { return std::string(take(size())); }
  // Nothing may follow.
  void end() const {
    if (!bytes_.empty()) fail();
  }
  [[noreturn]] void fail() const { throw Error(damaged_); }

 private:
  std::string_view take(std::size_t count) {
    if (count > bytes_.size()) fail();
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }

  std::string_view bytes_;
  std::string damaged_;
};

}  // namespace raywalk::calibrate
