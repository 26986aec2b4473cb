#include "core/room/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <limits>
#include <mutex>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {

// HDF5 is called by one thread at a time, with identifiers that close themselves and failures that
// become Errors.
namespace hdf5 {
namespace {

std::string last_reason;  // of the last call of HDF5 that failed

// Walking downward ends at the function that detected the error, whose description is the most
// specific.
herr_t keep_last(unsigned, const H5E_error2_t* error, void*) {
  if (error->desc != nullptr && *error->desc != '\0') last_reason = error->desc;
  return 0;
}

// Instead of printing them.
herr_t keep_reason(hid_t stack, void*) {
  return H5Ewalk2(stack, H5E_WALK_DOWNWARD, keep_last, nullptr);
}

// The system's error number that HDF5's file drivers put into their description:
// "file write failed: ..., errno = 28, error message = 'No space left on device', ..."; 0: none.
int error_number_in(const std::string& reason) {
  constexpr std::string_view kBefore = "errno = ";
  const std::size_t at = reason.find(kBefore);
  return at == std::string::npos ? 0 : std::atoi(reason.c_str() + at + kBefore.size());
}

std::string meaning_of_failure() {
  const int number = error_number_in(last_reason);
  if (number == ENOSPC || number == EDQUOT) {
    return "the disk is full; free some space and run the command again";
  }
  if (number != 0) {
    return std::generic_category().message(number) +
           "; check the disk and the file's permissions, and run the command again";
  }
  return "the file is damaged or was cut short; restore it from a copy or create it again" +
         (last_reason.empty() ? "" : " (HDF5: " + one_line(last_reason) + ")");
}

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

// Held while HDF5 is used; what it says of failures is kept from then on. The first call disables
// HDF5's cleanup at exit (see Hdf5File::writing), which must precede its initialisation.
std::unique_lock<std::mutex> locked() {
  static std::mutex library;
  std::unique_lock lock(library);
  static const bool no_cleaning_at_exit = H5dont_atexit() >= 0;
  static_cast<void>(no_cleaning_at_exit);
  H5Eset_auto2(H5E_DEFAULT, keep_reason, nullptr);
  last_reason.clear();
  return lock;
}

[[noreturn]] void throw_failure(const std::filesystem::path& file, const std::string& what) {
  throw Error(fmt::format("{}: {}: {}", file.string(), what, meaning_of_failure()));
}

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
hid_t type_of(ElementType type) {
  // In the order of the enumerators.
  const std::array types{H5T_STD_U8LE, H5T_STD_I32LE, H5T_STD_U64LE, H5T_IEEE_F32LE,
                         H5T_IEEE_F64LE};
  return types.at(static_cast<std::size_t>(type));
}

template <typename T>
constexpr ElementType kElementOf = std::is_same_v<T, double>         ? ElementType::kFloat64
                                   : std::is_same_v<T, std::int32_t> ? ElementType::kInt32
                                                                     : ElementType::kUint64;

// An open dataset, and how it is stored.
struct Dataset {
  Dataset(hid_t file, const std::string& name)
      : id(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose),
        type(H5Dget_type(id), H5Tclose),
        properties(H5Dget_create_plist(id), H5Pclose) {
    const Id space(H5Dget_space(id), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    check(rank);
    std::vector<hsize_t> dims(static_cast<std::size_t>(rank));
    check(H5Sget_simple_extent_dims(space, dims.data(), nullptr));
    shape = {dims.begin(), dims.end()};
  }

  Id id, type, properties;
  Shape shape;
};

std::vector<hsize_t> dims_of(const Shape& shape) { return {shape.begin(), shape.end()}; }

Id space_of(const Shape& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), dims_of(shape).data(), nullptr),
          H5Sclose};
}

// The shape of one index of the first dimension, and its place among a file's values.
Shape slab_of(Shape shape) {
  shape.front() = 1;
  return shape;
}

Id slab_space(const Shape& shape, std::size_t index) {
  std::vector<hsize_t> start(shape.size(), 0);
  start.front() = index;
  Id space = space_of(shape);
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr,
                            dims_of(slab_of(shape)).data(), nullptr));
  return space;
}

}  // namespace
}  // namespace hdf5

namespace {

namespace fs = std::filesystem;
using hdf5::check;
using hdf5::Id;

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
  const Id space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_npoints(space) == 1;
}

bool is_text(hid_t type) {
  return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
         H5Tget_size(type) <= kMostSmallBytes;
}

constexpr unsigned kDeflateLevel = 4;  // higher ones save a hundredth

// Creates a dataset that is contiguous or, with a shape of chunks, in these, through the filters
// that `add_filters` adds to its properties.
Id created(hid_t file, const std::string& name, hid_t type, const Shape& shape,
           const Shape& chunk = {}, const std::function<void(hid_t)>& add_filters = {}) {
  const Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  // Without times, files of the same content have the same bytes.
  check(H5Pset_obj_track_times(properties, false));
  if (chunk.empty()) {
    check(H5Pset_layout(properties, H5D_CONTIGUOUS));
    check(H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY));
    check(H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER));
  } else {
    const std::vector<hsize_t> dims = hdf5::dims_of(chunk);
    check(H5Pset_chunk(properties, static_cast<int>(dims.size()), dims.data()));
    add_filters(properties);
  }
  return {H5Dcreate2(file, name.c_str(), type, hdf5::space_of(shape), H5P_DEFAULT, properties,
                     H5P_DEFAULT),
          H5Dclose};
}

void write_whole(hid_t file, const std::string& name, hid_t type, const Shape& shape,
                 const void* values) {
  check(H5Dwrite(created(file, name, type, shape), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
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
  hdf5::guarded(path_, fmt::format("attribute '{}' cannot be read", name), [&] {
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

// HDF5 1.10 crashes when it closes a file whose buffers cannot be written (disk full), even at
// process exit, so after a failed write the file is never closed.
template <typename Call>
auto Hdf5File::writing(const std::string& what, const Call& call) {
  try {
    return hdf5::guarded(path_, "cannot " + what, call);
  } catch (const Error&) {
    file_ = -1;
    throw;
  }
}

Hdf5File Hdf5File::create(const fs::path& path) {
  Hdf5File file(path);
  hdf5::guarded(path, "cannot create the file", [&] {
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // The format of HDF5 1.10: its metadata have checksums, so that damage is detected.
    check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
    // Datasets are memory-mapped, so their numbers must be aligned in the file.
    check(H5Pset_alignment(access, 1, 8));
    const Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(creation, false));
    file.file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access);
    if (file.file_ < 0) throw hdf5::Failure();
  });
  return file;
}

void Hdf5File::write_format(const std::string& format, int version) {
  write_attribute("/", "format", format);
  writing("write attribute format_version",
          [&] { write_scalar(file_, "/", "format_version", H5T_STD_I32LE, &version); });
}

void Hdf5File::write_attribute(const std::string& where, const std::string& name,
                               const std::string& text) {
  writing("write attribute " + name,
          [&] { write_scalar(file_, where, name, text_type(text.size()), text.data()); });
}

template <typename T>
void Hdf5File::write(const std::string& name, const std::vector<T>& values, Shape shape) {
  if (shape.empty()) shape = {values.size()};
  writing(fmt::format("write dataset '{}'", name), [&] {
    write_whole(file_, name, hdf5::type_of(hdf5::kElementOf<T>), shape, values.data());
  });
}
template void Hdf5File::write(const std::string&, const std::vector<std::int32_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<std::uint64_t>&, Shape);
template void Hdf5File::write(const std::string&, const std::vector<double>&, Shape);

void Hdf5File::write_strings(const std::string& name, const std::vector<std::string>& values) {
  std::string all;
  for (const std::string& value : values) all += value;
  writing(fmt::format("write dataset '{}'", name), [&] {
    write_whole(file_, name, text_type(values.front().size()), {values.size()}, all.data());
  });
}

void Hdf5File::create_contiguous(const std::string& name, ElementType type, const Shape& shape) {
  writing(fmt::format("create dataset '{}'", name),
          [&] { created(file_, name, hdf5::type_of(type), shape); });
}

void Hdf5File::create_deflated(const std::string& name, ElementType type, const Shape& shape) {
  writing(fmt::format("create dataset '{}'", name), [&] {
    created(file_, name, hdf5::type_of(type), shape, hdf5::slab_of(shape), [](hid_t properties) {
      check(H5Pset_shuffle(properties));
      check(H5Pset_deflate(properties, kDeflateLevel));
    });
  });
}

void Hdf5File::create_encoded(const std::string& name, const Shape& shape, const Shape& chunk,
                              int filter, const std::vector<unsigned>& filter_values) {
  writing(fmt::format("create dataset '{}'", name), [&] {
    created(file_, name, H5T_STD_U8LE, shape, chunk, [&](hid_t properties) {
      // HDF5 requires a filter that is not optional to be there where the dataset is created.
      check(H5Pset_filter(properties, filter, H5Z_FLAG_OPTIONAL, filter_values.size(),
                          filter_values.data()));
    });
  });
}

void Hdf5File::write_slab(const std::string& name, std::size_t index, const void* values) {
  writing("write", [&] {
    const hdf5::Dataset dataset(file_, name);
    const Shape& shape = dataset.shape;
    check(H5Dwrite(dataset.id, dataset.type, hdf5::space_of(hdf5::slab_of(shape)),
                   hdf5::slab_space(shape, index), H5P_DEFAULT, values));
  });
}

FilePlace Hdf5File::write_chunk(const std::string& name, const Shape& start,
                                std::span<const std::uint8_t> encoded) {
  return writing("write", [&] {
    const hdf5::Dataset dataset(file_, name);
    const std::vector<hsize_t> place = hdf5::dims_of(start);
    unsigned skipped_filters = 0;
    haddr_t begin = HADDR_UNDEF;
    hsize_t bytes = 0;
    check(H5Dwrite_chunk(dataset.id, H5P_DEFAULT, 0, place.data(), encoded.size(), encoded.data()));
    check(H5Dget_chunk_info_by_coord(dataset.id, place.data(), &skipped_filters, &begin, &bytes));
    return FilePlace{begin, bytes};
  });
}

void Hdf5File::close() {
  writing("write", [&] {
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));
    check(H5Fclose(std::exchange(file_, -1)));
  });
}

}  // namespace raywalk
