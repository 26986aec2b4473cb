#include "capture/camera/gpio_lines.h"

#include <cerrno>
#include <system_error>

namespace raywalk::capture {
namespace {

std::string errno_text(int error) { return std::generic_category().message(error); }

std::string permission_advice(const std::string& path) {
  return "no permission for " + path + "; add this user to the group that owns it (ls -l " + path +
         " shows it)";
}

std::string line_name(const std::string& path, int offset) {
  return "line " + std::to_string(offset) + " of " + path;
}

}  // namespace

std::string gpio_chip_path(const std::string& chip) {
  return chip.find('/') == std::string::npos ? "/dev/" + chip : chip;
}

DeviceFault gpio_open_fault(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return {FaultKind::kNoContact,
              "no GPIO chip " + path + "; set trigger.chip to one that gpiodetect lists"};
    case EACCES:
    case EPERM:
      return {FaultKind::kNoContact, permission_advice(path)};
    case ENOTTY:
    case ENODEV:
    case EINVAL:
      return {FaultKind::kWrongDevice,
              path + " is not a GPIO chip; set trigger.chip to one that gpiodetect lists"};
    default:
      return {FaultKind::kNoContact,
              "cannot open GPIO chip " + path + " (" + errno_text(error) + "); see gpiodetect"};
  }
}

DeviceFault gpio_request_fault(const GpioRequestFailure& failure) {
  const std::string line = line_name(failure.path, failure.offset);
  if (failure.offset < 0 || failure.offset >= failure.line_count) {
    return {FaultKind::kWrongDevice,
            "there is no " + line + ", which has " + std::to_string(failure.line_count) +
                " lines counted from 0; correct the line in the trigger section"};
  }
  switch (failure.error) {
    case EBUSY:
      return {FaultKind::kNoContact,
              line + " is in use by " +
                  (failure.consumer.empty() ? "another program" : excerpt(failure.consumer)) +
                  "; end it or choose another line"};
    case EACCES:
    case EPERM:
      return {FaultKind::kNoContact, permission_advice(failure.path)};
    default:
      return {FaultKind::kNoContact,
              "cannot request " + line + " (" + errno_text(failure.error) + "); see gpioinfo"};
  }
}

DeviceFault gpio_line_fault(const std::string& path, int offset, int error) {
  return {FaultKind::kNoContact, line_name(path, offset) + " no longer answers (" +
                                     errno_text(error) +
                                     "); check that the chip is still there with gpiodetect"};
}

}  // namespace raywalk::capture
