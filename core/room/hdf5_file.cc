#include "core/room/hdf5_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSmallElements = std::size_t{1} << 24;

// Walking downward ends at the function that detected the error, whose description is the most
// specific.
herr_t keep_last(unsigned, const H5E_error2_t* error, void* reason) {
  if (error->desc != nullptr && *error->desc != '\0') {
    *static_cast<std::string*>(reason) = error->desc;
  }
  return 0;
}

std::string innermost_reason() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep_last, &reason);
  return reason;
}

// The system's error number that HDF5's file drivers put into their description:
// "file write failed: ..., errno = 28, error message = 'No space left on device', ..."; 0: none.
int error_number_in(const std::string& reason) {
  constexpr std::string_view kBefore = "errno = ";
  const std::size_t at = reason.find(kBefore);
  return at == std::string::npos ? 0 : std::atoi(reason.c_str() + at + kBefore.size());
}

// What a failure means, and what to do.
std::string meaning_of(const std::string& reason) {
  const int number = error_number_in(reason);
  if (number == ENOSPC || number == EDQUOT) {
    return "the disk is full; free some space and run the command again";
  }
  if (number != 0) {
    return std::generic_category().message(number) +
           "; check the disk and the file's permissions, and run the command again";
  }
  return "the file is damaged or was cut short; restore it from a copy or create it again" +
         (reason.empty() ? "" : " (HDF5: " + one_line(reason) + ")");
}

// HDF5 file format specification, section II.A: the byte after the eight of the signature is the
// version of the superblock; from version 2 on superblock and metadata are checksummed. HDF5 1.10
// can read past its own buffers on damaged metadata of the older format.
constexpr int kChecksummedSuperblock = 2;
int superblock_version(const fs::path& file) {
  const std::string head = read_file_prefix(file, 9);
  return head.size() < 9 ? 0 : static_cast<unsigned char>(head[8]);
}

}  // namespace

void require_shape(std::span<const std::size_t> found, std::span<const std::size_t> expected,
                   const std::string& name, const fs::path& file) {
  if (std::ranges::equal(found, expected)) return;
  throw Error(fmt::format("{}: dataset '{}' has the shape [{}], the manifest says [{}]",
                          file.string(), name, fmt::join(found, ", "), fmt::join(expected, ", ")));
}

void Hdf5File::prepare_library_for_this_thread() {
  static const bool no_cleaning_at_exit = H5dont_atexit() >= 0;
  static_cast<void>(no_cleaning_at_exit);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::vector<hsize_t> Hdf5File::dims_of(std::span<const std::size_t> shape) {
  return {shape.begin(), shape.end()};
}

Hdf5Handle::Hdf5Handle(Hdf5Handle&& other) noexcept
    : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}

Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(closer_, other.closer_);
  return *this;
}

Hdf5Handle::~Hdf5Handle() { close(); }

bool Hdf5Handle::close() {
  const hid_t id = std::exchange(id_, H5I_INVALID_HID);
  return id < 0 || closer_(id) >= 0;
}

Hdf5File Hdf5File::open(const fs::path& file) {
  prepare_library_for_this_thread();
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    throw Error(file.string() + (fs::exists(file, error) ? ": not a file" : ": no such file"));
  }
  Hdf5File opened;
  opened.path_ = file;
  if (H5Fis_hdf5(file.c_str()) == 0) throw Error(file.string() + ": not an HDF5 file");
  if (superblock_version(file) < kChecksummedSuperblock) {
    throw Error(file.string() +
                ": written without checksums, so not by Raywalk; pack the room again");
  }
  opened.file_ = opened.checked(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose,
                                "cannot open the file");
  return opened;
}

Hdf5File Hdf5File::create(const fs::path& file) {
  prepare_library_for_this_thread();
  Hdf5File created;
  created.path_ = file;
  const Hdf5Handle access =
      created.checked(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "cannot create the file");
  // The format of HDF5 1.10: its metadata have checksums, so that damage is detected.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110);
  // Datasets are memory-mapped, so their numbers must be aligned in the file.
  constexpr hsize_t kAlignment = 8;
  H5Pset_alignment(access.get(), 1, kAlignment);
  const Hdf5Handle creation =
      created.checked(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "cannot create the file");
  // Without times, files of the same content have the same bytes.
  H5Pset_obj_track_times(creation.get(), false);
  created.file_ =
      created.checked(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                      H5Fclose, "cannot create the file");
  return created;
}

void Hdf5File::require_format(const std::string& format) const {
  const auto open_attribute = [&](const char* name) {
    return checked(H5Aopen(file_.get(), name, H5P_DEFAULT), H5Aclose,
                   fmt::format("attribute '{}' cannot be read; not a Raywalk volume", name));
  };
  const Hdf5Handle format_attribute = open_attribute("format");
  const Hdf5Handle type =
      checked(H5Aget_type(format_attribute.get()), H5Tclose, "attribute 'format'");
  std::string found(H5Tget_size(type.get()), '\0');
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0 ||
      found.size() != format.size() ||
      H5Aread(format_attribute.get(), type.get(), found.data()) < 0 || found != format) {
    throw Error(fmt::format("{}: its format is not {}", path_.string(), format));
  }
  const Hdf5Handle version_attribute = open_attribute("format_version");
  const Hdf5Handle space =
      checked(H5Aget_space(version_attribute.get()), H5Sclose, "attribute 'format_version'");
  int version = 0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 ||
      H5Aread(version_attribute.get(), H5T_NATIVE_INT, &version) < 0) {
    fail("attribute 'format_version' cannot be read");
  }
  if (version != kVolumeFormatVersion) {
    const bool newer = version > kVolumeFormatVersion;
    throw Error(fmt::format("{}: format version {} is {} than {}, the one this program reads; {}",
                            path_.string(), version, newer ? "newer" : "older",
                            kVolumeFormatVersion, newer ? "use a newer Raywalk" : "make it again"));
  }
}

std::optional<std::string> Hdf5File::text_attribute(const std::string& name) const {
  if (H5Aexists(file_.get(), name.c_str()) <= 0) return std::nullopt;
  const Hdf5Handle attribute = checked(H5Aopen(file_.get(), name.c_str(), H5P_DEFAULT), H5Aclose,
                                       fmt::format("attribute '{}' cannot be read", name));
  const Hdf5Handle type = checked(H5Aget_type(attribute.get()), H5Tclose, "type of " + name);
  const bool is_text = H5Tget_class(type.get()) == H5T_STRING &&
                       H5Tis_variable_str(type.get()) == 0 &&
                       H5Tget_size(type.get()) <= kMaxSmallElements;
  if (!is_text) return std::nullopt;
  std::string text(H5Tget_size(type.get()), '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) {
    fail(fmt::format("attribute '{}' cannot be read", name));
  }
  return text;
}

bool Hdf5File::has_dataset(const std::string& name) const {
  return H5Lexists(file_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Handle Hdf5File::open_dataset(const std::string& name) const {
  return checked(H5Dopen2(file_.get(), name.c_str(), H5P_DEFAULT), H5Dclose,
                 fmt::format("dataset '{}' cannot be opened", name));
}

std::vector<std::size_t> Hdf5File::shape_of(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  const Hdf5Handle space = checked(H5Dget_space(dataset.get()), H5Sclose, "dataspace of " + name);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) fail(fmt::format("dataset '{}' has no shape", name));
  std::vector<hsize_t> dims(static_cast<std::size_t>(rank));
  if (H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr) < 0) {
    fail(fmt::format("dataset '{}' has no shape", name));
  }
  return {dims.begin(), dims.end()};
}

std::size_t Hdf5File::element_count(const std::string& name, hid_t dataset) const {
  const Hdf5Handle space = checked(H5Dget_space(dataset), H5Sclose, "dataspace of " + name);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (count < 0 || static_cast<std::size_t>(count) > kMaxSmallElements) {
    throw Error(fmt::format("{}: dataset '{}' is too large", path_.string(), name));
  }
  return static_cast<std::size_t>(count);
}

std::vector<std::int32_t> Hdf5File::read_int32(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  std::vector<std::int32_t> values(element_count(name, dataset.get()));
  if (H5Dread(dataset.get(), H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    fail(fmt::format("dataset '{}' cannot be read", name));
  }
  return values;
}

std::vector<double> Hdf5File::read_float64(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  std::vector<double> values(element_count(name, dataset.get()));
  if (H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    fail(fmt::format("dataset '{}' cannot be read", name));
  }
  return values;
}

std::vector<std::string> Hdf5File::read_strings(const std::string& name) const {
  const Hdf5Handle dataset = open_dataset(name);
  const Hdf5Handle type = checked(H5Dget_type(dataset.get()), H5Tclose, "type of " + name);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0) {
    throw Error(fmt::format("{}: dataset '{}' does not hold strings", path_.string(), name));
  }
  const std::size_t count = element_count(name, dataset.get());
  const std::size_t length = H5Tget_size(type.get());
  if (length == 0 || length > kMaxSmallElements / std::max<std::size_t>(count, 1)) {
    throw Error(fmt::format("{}: dataset '{}' is too large", path_.string(), name));
  }
  std::string all(count * length, '\0');
  if (H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0) {
    fail(fmt::format("dataset '{}' cannot be read", name));
  }
  std::vector<std::string> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(all.substr(i * length, length));
  return values;
}

void Hdf5File::write_attribute(const std::string& where, const std::string& name,
                               const std::string& text) {
  const Hdf5Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose, name);
  H5Tset_size(type.get(), text.size());
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  const Hdf5Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Hdf5Handle attribute =
      checked(H5Acreate_by_name(file_.get(), where.c_str(), name.c_str(), type.get(), space.get(),
                                H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
              H5Aclose, "cannot write attribute " + name);
  if (H5Awrite(attribute.get(), type.get(), text.data()) < 0)
    fail_to_write("cannot write attribute " + name);
}

void Hdf5File::write_attribute(const std::string& where, const std::string& name, int value) {
  const Hdf5Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Hdf5Handle attribute =
      checked(H5Acreate_by_name(file_.get(), where.c_str(), name.c_str(), H5T_STD_I32LE,
                                space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
              H5Aclose, "cannot write attribute " + name);
  if (H5Awrite(attribute.get(), H5T_NATIVE_INT, &value) < 0)
    fail_to_write("cannot write attribute " + name);
}

void Hdf5File::write_int32(const std::string& name, std::span<const std::int32_t> values) {
  write_int32(name, values, std::array{values.size()});
}

void Hdf5File::write_int32(const std::string& name, std::span<const std::int32_t> values,
                           std::span<const std::size_t> shape) {
  write_small(name, H5T_STD_I32LE, shape, values.data());
}

void Hdf5File::write_float64(const std::string& name, std::span<const double> values,
                             std::span<const std::size_t> shape) {
  write_small(name, H5T_IEEE_F64LE, shape, values.data());
}

void Hdf5File::write_strings(const std::string& name, std::span<const std::string> values) {
  const Hdf5Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose, name);
  H5Tset_size(type.get(), values.front().size());
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  std::string all;
  for (const std::string& value : values) all += value;
  write_small(name, type.get(), std::array{values.size()}, all.data());
}

Hdf5Handle Hdf5File::create_contiguous(const std::string& name, hid_t type,
                                       std::span<const std::size_t> shape) {
  const std::string what = fmt::format("cannot create dataset '{}'", name);
  const std::vector<hsize_t> dims = dims_of(shape);
  const Hdf5Handle space = checked(
      H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose, what);
  const Hdf5Handle properties = checked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
  H5Pset_layout(properties.get(), H5D_CONTIGUOUS);
  H5Pset_obj_track_times(properties.get(), false);
  H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER);
  return checked(H5Dcreate2(file_.get(), name.c_str(), type, space.get(), H5P_DEFAULT,
                            properties.get(), H5P_DEFAULT),
                 H5Dclose, what);
}

void Hdf5File::write_slab(const Hdf5Handle& dataset, std::size_t index, hid_t type,
                          std::span<const std::size_t> shape, const void* values) {
  prepare_library_for_this_thread();
  std::vector<hsize_t> count = dims_of(shape);
  std::vector<hsize_t> start(count.size(), 0);
  const Hdf5Handle file_space =
      checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose,
              "cannot write");
  start[0] = index;
  count[0] = 1;
  const Hdf5Handle memory_space =
      checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose,
              "cannot write");
  if (H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                          nullptr) < 0 ||
      H5Dwrite(dataset.get(), type, memory_space.get(), file_space.get(), H5P_DEFAULT, values) <
          0) {
    fail_to_write("cannot write");
  }
}

void Hdf5File::close() {
  if (H5Fflush(file_.get(), H5F_SCOPE_LOCAL) < 0) fail_to_write("cannot write");
  if (!file_.close()) fail_to_write("cannot write");
}

void Hdf5File::fail(const std::string& what) const {
  throw Error(fmt::format("{}: {}: {}", path_.string(), what, meaning_of(innermost_reason())));
}

void Hdf5File::fail_to_write(const std::string& what) {
  file_.abandon();
  fail(what);
}

Hdf5Handle Hdf5File::checked(hid_t id, Hdf5Handle::Closer closer, const std::string& what) const {
  if (id < 0) fail(what);
  return {id, closer};
}

void Hdf5File::write_small(const std::string& name, hid_t type, std::span<const std::size_t> shape,
                           const void* values) {
  const Hdf5Handle dataset = create_contiguous(name, type, shape);
  if (H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
    fail_to_write(fmt::format("cannot write dataset '{}'", name));
  }
}

}  // namespace raywalk
