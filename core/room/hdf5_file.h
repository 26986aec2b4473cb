// The part of HDF5 that room volumes use. Failures throw Error naming the file and HDF5's reason.
// From any thread: calls wait for each other, as packaged HDF5 libraries are not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

// The root attribute `format_version` of lines/<id>.h5, distances/*/<id>.h5 and gains.h5. Files of
// other versions are refused.
inline constexpr int kVolumeFormatVersion = 6;

enum class ElementType { kUint8, kInt32, kUint64, kFloat32, kFloat64 };

using Shape = std::vector<std::size_t>;

// Where bytes are in a file.
struct FilePlace {
  std::uint64_t begin = 0;
  std::uint64_t bytes = 0;
};

// An open file.
class Hdf5File {
 public:
  // Throw Error naming the file. `create` replaces an existing file.
  static Hdf5File open(const std::filesystem::path& file);
  static Hdf5File create(const std::filesystem::path& file);
  Hdf5File(Hdf5File&& other) noexcept;
  ~Hdf5File();

  const std::filesystem::path& path() const { return path_; }

  // Throws Error unless the root attribute `format` is `format` and its version is the current one.
  void require_format(const std::string& format) const;
  // A root attribute; none if the file has no text attribute of this name.
  std::optional<std::string> text_attribute(const std::string& name) const;

  bool has_dataset(const std::string& name) const;
  Shape shape_of(const std::string& name) const;
  // Throws Error unless the shape is the expected one.
  void require_shape(const std::string& name, const Shape& expected) const;
  // A whole small dataset of std::int32_t, std::uint64_t or double, and one of strings of one fixed
  // length. The number of bytes is limited to 128 MiB.
  template <typename T>
  std::vector<T> read(const std::string& name) const;
  std::vector<std::string> read_strings(const std::string& name) const;
  // Where a contiguous dataset is. Throws Error unless it is one of this type, aligned, not empty
  // and whole.
  FilePlace place_of(const std::string& name, ElementType type) const;
  // The shape of a dataset's chunks; none where it is contiguous.
  std::optional<Shape> chunk_of(const std::string& name) const;
  // The values at one index of the first dimension. Throws Error unless `values` has their size.
  void read_slab(const std::string& name, std::size_t index, ElementType type,
                 std::span<std::byte> values) const;

  // The root attributes that require_format() compares.
  void write_format(const std::string& format, int version = kVolumeFormatVersion);
  // `where` is a dataset's name, "/" for the file itself.
  void write_attribute(const std::string& where, const std::string& name, const std::string& text);
  // A whole small dataset of the types of read(); without a shape, of one dimension.
  template <typename T>
  void write(const std::string& name, const std::vector<T>& values, Shape shape = {});
  // All strings must have the same length.
  void write_strings(const std::string& name, const std::vector<std::string>& values);

  // Creates a contiguous dataset; its space is allocated but not filled.
  void create_contiguous(const std::string& name, ElementType type, const Shape& shape);
  // One in chunks of one index of the first dimension each, compressed losslessly by HDF5's own
  // filters shuffle and deflate.
  void create_deflated(const std::string& name, ElementType type, const Shape& shape);
  // Writes the values at one index of the first dimension of either.
  void write_slab(const std::string& name, std::size_t index, const void* values);
  // One of bytes whose chunks the caller encodes. Other programs need HDF5's filter of this number
  // and values to decode them, this one need not have it.
  void create_encoded(const std::string& name, const Shape& shape, const Shape& chunk, int filter,
                      const std::vector<unsigned>& filter_values);
  // Writes an encoded chunk, which begins at `start`; returns where it is.
  FilePlace write_chunk(const std::string& name, const Shape& start,
                        std::span<const std::uint8_t> encoded);

  // Closes the file; throws Error if buffered data cannot be written (disk full).
  void close();

 private:
  explicit Hdf5File(std::filesystem::path path);
  // What `call` returns of an open dataset, and of what writes; with what failed for errors.
  template <typename Call>
  auto of_dataset(const std::string& name, const char* failure, const Call& call) const;
  template <typename Call>
  auto writing(const std::string& what, const Call& call);

  std::filesystem::path path_;
  std::int64_t file_ = -1;  // HDF5's identifier
};

}  // namespace raywalk
