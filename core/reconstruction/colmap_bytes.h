// The numbers and texts of COLMAP's binary files: little-endian, no padding. Internal to the
// readers and writers of models.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/reconstruction/colmap_pose.h"

namespace raywalk {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian");

class ColmapBytes {
 public:
  template <typename Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<char, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(Number));
    bytes_.append(bytes.data(), bytes.size());
  }
  void put_count(std::size_t count) { put(static_cast<std::uint64_t>(count)); }
  void put_text(const std::string& text) { bytes_.append(text).push_back('\0'); }
  void put_pose(const ColmapPose& pose) {
    const Eigen::Quaterniond& rotation = pose.rotation;
    for (const double value : {rotation.w(), rotation.x(), rotation.y(), rotation.z()}) put(value);
    for (const double value : pose.translation) put(value);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{};
};

// All functions throw Error naming `source` where the bytes end early or a number is not finite.
class ColmapByteReader {
 public:
  // `source` is the file, for errors.
  ColmapByteReader(std::string bytes, std::string source)
      : source_(std::move(source)), bytes_(std::move(bytes)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: {}; it is not a COLMAP model", source_, what));
  }

  template <typename Number>
  Number take() {
    if (bytes_.size() - at_ < sizeof(Number)) fail("cut short");
    Number number{};
    std::memcpy(&number, bytes_.data() + at_, sizeof(Number));
    at_ += sizeof(Number);
    return number;
  }

  double take_number() {
    const auto number = take<double>();
    if (!std::isfinite(number)) fail("a coordinate is not a finite number");
    return number;
  }

  Eigen::Vector3d take_vector() {
    const double x = take_number();
    const double y = take_number();
    return {x, y, take_number()};
  }

  ColmapPose take_pose() {
    const double w = take_number();
    const Eigen::Vector3d xyz = take_vector();
    const Eigen::Quaterniond rotation(w, xyz.x(), xyz.y(), xyz.z());
    if (!(rotation.norm() > 0.5 && rotation.norm() < 2.0)) fail("a rotation is not a quaternion");
    return {rotation.normalized(), take_vector()};
  }

  // The number of elements that follow. Each takes at least `element_bytes`, which bounds a damaged
  // count by the size of the file.
  std::size_t take_count(std::size_t element_bytes) {
    const auto count = take<std::uint64_t>();
    if (count > (bytes_.size() - at_) / element_bytes) fail("cut short");
    return static_cast<std::size_t>(count);
  }

  std::string take_text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("cut short");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }

  void skip(std::size_t bytes) {
    if (bytes > bytes_.size() - at_) fail("cut short");
    at_ += bytes;
  }

  void require_end() const {
    if (at_ != bytes_.size()) fail("bytes are left over at its end");
  }

 private:
  std::string source_;
  std::string bytes_;
  std::size_t at_ = 0;
};

}  // namespace raywalk
