#include "core/room/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/files/atomic_output.h"
#include "core/room/hdf5_calls.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using namespace hdf5;  // NOLINT(google-build-using-namespace): its functions are for this file

constexpr std::size_t kMostSmallBytes = std::size_t{1} << 27;

// HDF5 file format specification, section II.A: the byte after the eight of the signature is the
// version of the superblock; from version 2 on superblock and metadata are checksummed. HDF5 1.10
// can read past its own buffers on damaged metadata of the older format.
constexpr int kChecksummedSuperblock = 2;
int superblock_version(const fs::path& file) {
  const std::string head = read_file_prefix(file, 9);
  return head.size() < 9 ? 0 : static_cast<unsigned char>(head[8]);
}

bool has_one_value(hid_t attribute) {
  const Id space(H5Aget_space(attribute), H5Sclose);
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
  const std::lock_guard lock(library());
  if (file_ >= 0) H5Fclose(file_);
}

Hdf5File Hdf5File::open(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    throw Error(path.string() + (fs::exists(path, error) ? ": not a file" : ": no such file"));
  }
  Hdf5File file(path);
  file.guarded("cannot open the file", [&] {
    if (H5Fis_hdf5(path.c_str()) == 0) throw Error(path.string() + ": not an HDF5 file");
    if (superblock_version(path) < kChecksummedSuperblock) {
      throw Error(path.string() +
                  ": written without checksums, so not by Raywalk; pack the room again");
    }
    file.file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file.file_ < 0) throw Hdf5Failure();
  });
  return file;
}

Hdf5File Hdf5File::create(const fs::path& path) {
  Hdf5File file(path);
  file.guarded("cannot create the file", [&] {
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // The format of HDF5 1.10: its metadata have checksums, so that damage is detected.
    check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
    // Datasets are memory-mapped, so their numbers must be aligned in the file.
    check(H5Pset_alignment(access, 1, 8));
    const Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(creation, false));
    file.file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
    if (file.file_ < 0) throw Hdf5Failure();
  });
  return file;
}

void Hdf5File::require_format(const std::string& format) const {
  const auto found = text_attribute("format");
  if (!found) throw Error(path_.string() + ": no Raywalk volume: it has no attribute 'format'");
  if (*found != format) {
    throw Error(fmt::format("{}: its format is not {}", path_.string(), format));
  }
  const int version = guarded("attribute 'format_version' cannot be read", [&] {
    const Id attribute(H5Aopen(file_, "format_version", H5P_DEFAULT), H5Aclose);
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
  guarded(fmt::format("attribute '{}' cannot be read", name), [&] {
    if (H5Aexists(file_, name.c_str()) <= 0) return;
    const Id attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Id type(H5Aget_type(attribute), H5Tclose);
    if (!is_text(type) || !has_one_value(attribute)) return;
    text.emplace(H5Tget_size(type), '\0');
    check(H5Aread(attribute, type, text->data()));
  });
  return text;
}

bool Hdf5File::has_dataset(const std::string& name) const {
  return guarded("cannot be read", [&] { return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0; });
}

Shape Hdf5File::shape_of(const std::string& name) const {
  return guarded(fmt::format("dataset '{}' cannot be opened", name),
                 [&] { return shape_of_dataset(opened(file_, name)); });
}

void Hdf5File::require_shape(const std::string& name, const Shape& expected) const {
  const Shape found = shape_of(name);
  if (found == expected) return;
  throw Error(fmt::format("{}: dataset '{}' has the shape [{}], the manifest says [{}]",
                          path_.string(), name, fmt::join(found, ", "), fmt::join(expected, ", ")));
}

template <typename T>
std::vector<T> Hdf5File::read(const std::string& name) const {
  const auto bytes = bytes_of(shape_of(name), sizeof(T));
  if (!bytes || *bytes > kMostSmallBytes) {
    throw Error(fmt::format("{}: dataset '{}' is too large", path_.string(), name));
  }
  std::vector<T> values(*bytes / sizeof(T));
  guarded(fmt::format("dataset '{}' cannot be read", name), [&] {
    check(H5Dread(opened(file_, name), type_of(kElementOf<T>), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                  values.data()));
  });
  return values;
}
template std::vector<std::int32_t> Hdf5File::read(const std::string& name) const;
template std::vector<std::uint64_t> Hdf5File::read(const std::string& name) const;
template std::vector<double> Hdf5File::read(const std::string& name) const;

std::vector<std::string> Hdf5File::read_strings(const std::string& name) const {
  return guarded(fmt::format("dataset '{}' cannot be read", name), [&] {
    const Id dataset = opened(file_, name);
    const Id type = stored_type_of(dataset);
    if (!is_text(type)) {
      throw Error(fmt::format("{}: dataset '{}' does not hold strings", path_.string(), name));
    }
    const std::size_t length = H5Tget_size(type);
    const auto bytes = bytes_of(shape_of_dataset(dataset), length);
    if (length == 0 || !bytes || *bytes > kMostSmallBytes) {
      throw Error(fmt::format("{}: dataset '{}' is too large", path_.string(), name));
    }
    std::string all(*bytes, '\0');
    check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()));
    std::vector<std::string> values;
    for (std::size_t at = 0; at < all.size(); at += length)
      values.push_back(all.substr(at, length));
    return values;
  });
}

FilePlace Hdf5File::place_of(const std::string& name, ElementType type) const {
  return guarded(fmt::format("dataset '{}' cannot be opened", name), [&] {
    const Id dataset = opened(file_, name);
    const auto require = [&](bool right, const std::string& what) {
      if (!right) throw Error(fmt::format("{}: dataset '{}' {}", path_.string(), name, what));
    };
    require(H5Tequal(stored_type_of(dataset), type_of(type)) > 0, "is not of the right type");
    const Id properties = properties_of(dataset);
    require(H5Pget_layout(properties) == H5D_CONTIGUOUS && H5Pget_external_count(properties) == 0,
            "is not stored contiguously; pack the room again");
    const std::size_t element_bytes = H5Tget_size(type_of(type));
    const std::size_t bytes = bytes_of(shape_of_dataset(dataset), element_bytes).value_or(0);
    require(bytes > 0, "has an impossible shape");
    const haddr_t begin = H5Dget_offset(dataset);
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
  std::optional<Shape> chunk;
  guarded(fmt::format("dataset '{}' cannot be opened", name), [&] {
    const Id properties = properties_of(opened(file_, name));
    if (H5Pget_layout(properties) != H5D_CHUNKED) return;
    std::vector<hsize_t> dims(H5S_MAX_RANK);
    const int rank = H5Pget_chunk(properties, H5S_MAX_RANK, dims.data());
    check(rank);
    chunk.emplace(dims.begin(), dims.begin() + rank);
  });
  return chunk;
}

void Hdf5File::read_slab(const std::string& name, std::size_t index, ElementType type,
                         std::span<std::byte> values) const {
  guarded(fmt::format("entry {} of dataset '{}' cannot be read", index, name), [&] {
    const Id dataset = opened(file_, name);
    const Shape shape = shape_of_dataset(dataset);
    if (shape.empty() || bytes_of(slab_of(shape), H5Tget_size(type_of(type))) != values.size()) {
      throw Error(fmt::format("{}: dataset '{}' has another size", path_.string(), name));
    }
    check(H5Dread(dataset, type_of(type), space_of(slab_of(shape)), selected(shape, index),
                  H5P_DEFAULT, values.data()));
  });
}

}  // namespace raywalk
