// RAII wrappers of the part of HDF5 that room volumes use. Failures throw Error naming the file and
// HDF5's reason. Packaged HDF5 libraries are not thread-safe: callers must serialise their calls.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

// The root attribute `format_version` of lines/<id>.h5, distances/<id>.h5 and gains.h5. Files of
// other versions are refused.
inline constexpr int kVolumeFormatVersion = 5;

// Throws Error unless a dataset's shape is the expected one.
void require_shape(std::span<const std::size_t> found, std::span<const std::size_t> expected,
                   const std::string& name, const std::filesystem::path& file);

// Owns an HDF5 identifier and its close function.
class Hdf5Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Closer closer) : id_(id), closer_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle();

  hid_t get() const { return id_; }
  // Closes now; false on failure, e.g. when buffered data cannot be written.
  bool close();
  // Releases the identifier without closing it.
  void abandon() { id_ = H5I_INVALID_HID; }

 private:
  hid_t id_ = H5I_INVALID_HID;
  Closer closer_ = nullptr;
};

// An open HDF5 file.
class Hdf5File {
 public:
  // Throw Error naming the file. `create` replaces an existing file.
  static Hdf5File open(const std::filesystem::path& file);
  static Hdf5File create(const std::filesystem::path& file);

  const std::filesystem::path& path() const { return path_; }
  hid_t id() const { return file_.get(); }

  // Throws Error unless the root attribute `format` is `format` and its version is the current one.
  void require_format(const std::string& format) const;

  // A root attribute; none if the file has no text attribute of this name.
  std::optional<std::string> text_attribute(const std::string& name) const;
  bool has_dataset(const std::string& name) const;
  Hdf5Handle open_dataset(const std::string& name) const;
  std::vector<std::size_t> shape_of(const std::string& name) const;
  // Whole small datasets. The element count is limited to 16 million.
  std::vector<std::int32_t> read_int32(const std::string& name) const;
  std::vector<double> read_float64(const std::string& name) const;
  // A dataset of strings of one fixed length.
  std::vector<std::string> read_strings(const std::string& name) const;

  // `where` is a group or dataset path, "/" for the file itself.
  void write_attribute(const std::string& where, const std::string& name, const std::string& text);
  void write_attribute(const std::string& where, const std::string& name, int value);
  void write_int32(const std::string& name, std::span<const std::int32_t> values);
  void write_int32(const std::string& name, std::span<const std::int32_t> values,
                   std::span<const std::size_t> shape);
  void write_float64(const std::string& name, std::span<const double> values,
                     std::span<const std::size_t> shape);
  // All strings must have the same length.
  void write_strings(const std::string& name, std::span<const std::string> values);
  // Creates a contiguous dataset; its space is allocated but not filled.
  Hdf5Handle create_contiguous(const std::string& name, hid_t type,
                               std::span<const std::size_t> shape);
  // Writes the values at one index of the first dimension; `type` is their type in memory.
  void write_slab(const Hdf5Handle& dataset, std::size_t index, hid_t type,
                  std::span<const std::size_t> shape, const void* values);

  // Creates a dataset in chunks of one index of the first dimension each, with a filter that this
  // program need not have: chunks are written encoded.
  Hdf5Handle create_filtered(const std::string& name, hid_t type,
                             std::span<const std::size_t> shape, int filter);
  // Writes the encoded chunk at one index of the first dimension; returns where it is in the file.
  std::uint64_t write_chunk(const Hdf5Handle& dataset, std::size_t index,
                            std::span<const std::uint8_t> encoded);

  // Creates a dataset in chunks of one index of the first dimension each, compressed losslessly by
  // HDF5's own filters as write_slab writes them.
  Hdf5Handle create_deflated(const std::string& name, hid_t type,
                             std::span<const std::size_t> shape);
  // Whether a dataset is stored in chunks.
  bool is_chunked(const std::string& name) const;
  // Where the chunk at each index of the first dimension is. Throws Error unless the dataset has
  // this type and is as create_deflated makes them.
  struct ChunkPlace {
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
    bool deflated = true;  // false: only shuffled, as it would not become smaller
  };
  std::vector<ChunkPlace> deflated_chunks(const std::string& name, hid_t type) const;

  // Closes the file; throws Error if buffered data cannot be written (disk full).
  void close();

  // Throws Error: "<file>: <what>: <HDF5's innermost reason>".
  [[noreturn]] void fail(const std::string& what) const;

 private:
  // Disables HDF5's printing of the per-thread error stack to stderr; fail() reads the stack
  // instead. The first call also disables HDF5's cleanup at exit (see fail_to_write) and must
  // precede HDF5's initialisation.
  static void prepare_library_for_this_thread();
  static std::vector<hsize_t> dims_of(std::span<const std::size_t> shape);

  // The same after a failed write. HDF5 1.10 crashes when it closes a file whose buffers cannot be
  // written (disk full), even at process exit, so the file is never closed.
  [[noreturn]] void fail_to_write(const std::string& what);
  Hdf5Handle checked(hid_t id, Hdf5Handle::Closer closer, const std::string& what) const;
  // Creates a dataset in chunks of one index of the first dimension each. `add_filters` adds to the
  // properties of its creation; false if that fails.
  Hdf5Handle create_chunked(const std::string& name, hid_t type, std::span<const std::size_t> shape,
                            const std::function<bool(hid_t properties)>& add_filters) const;
  std::size_t element_count(const std::string& name, hid_t dataset) const;
  void write_small(const std::string& name, hid_t type, std::span<const std::size_t> shape,
                   const void* values);

  std::filesystem::path path_;
  Hdf5Handle file_;
};

}  // namespace raywalk
