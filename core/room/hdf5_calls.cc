#include "core/room/hdf5_calls.h"

#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>

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

}  // namespace

std::recursive_mutex& library() {
  static std::recursive_mutex the_only_one;
  return the_only_one;
}

// The first call also disables HDF5's cleanup at exit (see write_guarded), which must precede its
// initialisation.
void prepare_library() {
  static const bool no_cleaning_at_exit = H5dont_atexit() >= 0;
  static_cast<void>(no_cleaning_at_exit);
  H5Eset_auto2(H5E_DEFAULT, keep_reason, nullptr);
  last_reason.clear();
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

}  // namespace raywalk::hdf5
