#include "core/room/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/room/hdf5_calls.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using hdf5::check;

constexpr std::size_t kMostSmallBytes = std::size_t{1} << 27;

// Of all values; none where that is no number of bytes.
std::optional<std::size_t> bytes_of(const Shape& shape, std::size_t bytes) {
  for (const std::size_t extent : shape) {
    if (extent != 0 && bytes > std::numeric_limits<std::size_t>::max() / 2 / extent) return {};
    bytes *= extent;
  }
  return bytes;
}

// The same of a dataset that is read whole. Throws Error where it is too large for that.
std::size_t small_bytes_of(const fs::path& file, const std::string& name, const Shape& shape,
                           std::size_t element_bytes) {
  const auto bytes = bytes_of(shape, element_bytes);
  if (!bytes || *bytes > kMostSmallBytes) {
    throw Error(fmt::format("{}: dataset '{}' is too large", file.string(), name));
  }
  return *bytes;
}

// HDF5 file format specification, section II.A: the byte after the eight of the signature is the
// version of the superblock; from version 2 on superblock and metadata are checksummed. HDF5 1.10
// can read past its own buffers on damaged metadata of the older format.
bool has_checksums(const fs::path& file) {
  const std::string head = read_file_prefix(file, 9);
  return head.size() == 9 && static_cast<unsigned char>(head[8]) >= 2;
}

bool has_one_value(hid_t attribute) {
  const hdf5::Id space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_npoints(space) == 1;
}

bool is_text(hid_t type) {
  return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
         H5Tget_size(type) <= kMostSmallBytes;
}

}  // namespace

Hdf5File::Hdf5File(fs::path path) : path_(std::move(path)) {}
Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}
Hdf5File::~Hdf5File() {
  if (file_ < 0) return;
  const auto lock = hdf5::locked();
  H5Fclose(file_);
}

Hdf5File Hdf5File::open(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    throw Error(path.string() + (fs::exists(path, error) ? ": not a file" : ": no such file"));
  }
  Hdf5File file(path);
  hdf5::guarded(path, "cannot open the file", [&] {
    if (H5Fis_hdf5(path.c_str()) == 0) throw Error(path.string() + ": not an HDF5 file");
    if (!has_checksums(path)) {
      throw Error(path.string() +
                  ": written without checksums, so not by Raywalk; pack the room again");
    }
    file.file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file.file_ < 0) throw hdf5::Failure();
  });
  return file;
}

void Hdf5File::require_format(const std::string& format) const {
  const auto found = text_attribute("format");
  if (!found) throw Error(path_.string() + ": no Raywalk volume: it has no attribute 'format'");
  if (*found != format) {
    throw Error(fmt::format("{}: its format is not {}", path_.string(), format));
  }
  const int version = hdf5::guarded(path_, "attribute 'format_version' cannot be read", [&] {
    const hdf5::Id attribute(H5Aopen(file_, "format_version", H5P_DEFAULT), H5Aclose);
    int value = 0;
    if (has_one_value(attribute)) check(H5Aread(attribute, H5T_NATIVE_INT, &value));
    return value;
  });
  if (version == kVolumeFormatVersion) return;
  const bool newer = version > kVolumeFormatVersion;
  throw Error(fmt::format("{}: format version {} is {} than {}, the one this program reads; {}",
                          path_.string(), version, newer ? "newer" : "older", kVolumeFormatVersion,
                          newer ? "use a newer Raywalk" : "make it again"));
}

std::optional<std::string> Hdf5File::text_attribute(const std::string& name) const {
  std::optional<std::string> text;
  hdf5::guarded(path_, fmt::format("attribute '{}' cannot be read", name), [&] {
    if (H5Aexists(file_, name.c_str()) <= 0) return;
    const hdf5::Id attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose);
    const hdf5::Id type(H5Aget_type(attribute), H5Tclose);
    if (!is_text(type) || !has_one_value(attribute)) return;
    text.emplace(H5Tget_size(type), '\0');
    check(H5Aread(attribute, type, text->data()));
  });
  return text;
}

bool Hdf5File::has_dataset(const std::string& name) const {
  return hdf5::guarded(path_, "cannot be read",
                       [&] { return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0; });
}

template <typename Call>
auto Hdf5File::of_dataset(const std::string& name, const char* failure, const Call& call) const {
  return hdf5::guarded(path_, fmt::format("dataset '{}' {}", name, failure),
                       [&] { return call(hdf5::Dataset(file_, name)); });
}

Shape Hdf5File::shape_of(const std::string& name) const {
  return of_dataset(name, "cannot be opened",
                    [](const hdf5::Dataset& dataset) { return dataset.shape; });
}

void Hdf5File::require_shape(const std::string& name, const Shape& expected) const {
  const Shape found = shape_of(name);
  if (found == expected) return;
  throw Error(fmt::format("{}: dataset '{}' has the shape [{}], the manifest says [{}]",
                          path_.string(), name, fmt::join(found, ", "), fmt::join(expected, ", ")));
}

template <typename T>
std::vector<T> Hdf5File::read(const std::string& name) const {
  return of_dataset(name, "cannot be read", [&](const hdf5::Dataset& dataset) {
    std::vector<T> values(small_bytes_of(path_, name, dataset.shape, sizeof(T)) / sizeof(T));
    check(H5Dread(dataset.id, hdf5::type_of(hdf5::kElementOf<T>), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  values.data()));
    return values;
  });
}
template std::vector<std::int32_t> Hdf5File::read(const std::string& name) const;
template std::vector<std::uint64_t> Hdf5File::read(const std::string& name) const;
template std::vector<double> Hdf5File::read(const std::string& name) const;

std::vector<std::string> Hdf5File::read_strings(const std::string& name) const {
  return of_dataset(name, "cannot be read", [&](const hdf5::Dataset& dataset) {
    const std::size_t length = H5Tget_size(dataset.type);
    if (!is_text(dataset.type) || length == 0) {
      throw Error(fmt::format("{}: dataset '{}' does not hold strings", path_.string(), name));
    }
    std::string all(small_bytes_of(path_, name, dataset.shape, length), '\0');
    check(H5Dread(dataset.id, dataset.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()));
    std::vector<std::string> values;
    values.reserve(all.size() / length);
    for (std::size_t at = 0; at < all.size(); at += length) {
      values.push_back(all.substr(at, length));
    }
    return values;
  });
}

FilePlace Hdf5File::place_of(const std::string& name, ElementType type) const {
  return of_dataset(name, "cannot be opened", [&](const hdf5::Dataset& dataset) {
    const auto require = [&](bool right, const std::string& what) {
      if (!right) throw Error(fmt::format("{}: dataset '{}' {}", path_.string(), name, what));
    };
    require(H5Tequal(dataset.type, hdf5::type_of(type)) > 0, "is not of the right type");
    require(H5Pget_layout(dataset.properties) == H5D_CONTIGUOUS &&
                H5Pget_external_count(dataset.properties) == 0,
            "is not stored contiguously; pack the room again");
    const std::size_t element_bytes = H5Tget_size(dataset.type);
    const std::size_t bytes = bytes_of(dataset.shape, element_bytes).value_or(0);
    require(bytes > 0, "has an impossible shape");
    const haddr_t begin = H5Dget_offset(dataset.id);
    require(begin != HADDR_UNDEF, "has never been written");
    require(begin % element_bytes == 0, "is not aligned; pack the room again");
    // Touching a mapped page past the end of the file would kill the process (SIGBUS).
    const std::uint64_t there = fs::file_size(path_);
    const std::uint64_t behind = there - std::min<std::uint64_t>(there, begin);
    require(bytes <= behind, fmt::format("is cut short: {} of {} bytes are there", behind, bytes));
    return FilePlace{begin, bytes};
  });
}

std::optional<Shape> Hdf5File::chunk_of(const std::string& name) const {
  return of_dataset(
      name, "cannot be opened", [](const hdf5::Dataset& dataset) -> std::optional<Shape> {
        if (H5Pget_layout(dataset.properties) != H5D_CHUNKED) return {};
        std::vector<hsize_t> dims(dataset.shape.size());
        check(H5Pget_chunk(dataset.properties, static_cast<int>(dims.size()), dims.data()));
        return Shape(dims.begin(), dims.end());
      });
}

void Hdf5File::read_slab(const std::string& name, std::size_t index, ElementType type,
                         std::span<std::byte> values) const {
  hdf5::guarded(path_, fmt::format("entry {} of dataset '{}' cannot be read", index, name), [&] {
    const hdf5::Dataset dataset(file_, name);
    const Shape& shape = dataset.shape;
    const hid_t stored = hdf5::type_of(type);
    if (shape.empty() || bytes_of(hdf5::slab_of(shape), H5Tget_size(stored)) != values.size()) {
      throw Error(fmt::format("{}: dataset '{}' has another size", path_.string(), name));
    }
    check(H5Dread(dataset.id, stored, hdf5::space_of(hdf5::slab_of(shape)),
                  hdf5::slab_space(shape, index), H5P_DEFAULT, values.data()));
  });
}

}  // namespace raywalk
