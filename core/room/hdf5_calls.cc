#include "core/room/hdf5_calls.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::hdf5 {
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

}  // namespace

// The first call also disables HDF5's cleanup at exit (see Hdf5File::writing), which must precede
// its initialisation.
std::unique_lock<std::mutex> locked() {
  static std::mutex library;
  std::unique_lock lock(library);
  static const bool no_cleaning_at_exit = H5dont_atexit() >= 0;
  static_cast<void>(no_cleaning_at_exit);
  H5Eset_auto2(H5E_DEFAULT, keep_reason, nullptr);
  last_reason.clear();
  return lock;
}

void throw_failure(const std::filesystem::path& file, const std::string& what) {
  throw Error(fmt::format("{}: {}: {}", file.string(), what, meaning_of_failure()));
}

hid_t type_of(ElementType type) {
  // In the order of the enumerators.
  const std::array types{H5T_STD_U8LE, H5T_STD_I32LE, H5T_STD_U64LE, H5T_IEEE_F32LE,
                         H5T_IEEE_F64LE};
  return types.at(static_cast<std::size_t>(type));
}

Dataset::Dataset(hid_t file, const std::string& name)
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

std::vector<hsize_t> dims_of(const Shape& shape) { return {shape.begin(), shape.end()}; }

Id space_of(const Shape& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), dims_of(shape).data(), nullptr),
          H5Sclose};
}

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

}  // namespace raywalk::hdf5
