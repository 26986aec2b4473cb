#include "capture/camera/check_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "capture/base/device_fault.h"
#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk::capture {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  throw DeviceFault(FaultKind::kBadPicture, what);
}

std::string start_of(const std::string& bytes) {
  constexpr std::size_t kLongest = 64;
  const std::size_t begin = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  std::string start = bytes.substr(begin, kLongest);
  std::transform(start.begin(), start.end(), start.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return start;
}

// Error pages and messages that servers send instead of a picture.
void refuse_text(const std::string& bytes, const std::string& source) {
  const std::string start = start_of(bytes);
  if (start.starts_with("<!doctype") || start.starts_with("<html") || start.starts_with("<?xml")) {
    refuse(source +
           ": a web page instead of a picture; check the camera's address and its network");
  }
  if (start.starts_with("{") || start.starts_with("[")) {
    refuse(source + ": a message instead of a picture: " + excerpt(bytes) +
           "; if this persists, switch the camera off and on");
  }
}

}  // namespace

CheckedPicture check_picture(const std::string& bytes, PanoramaSize expected,
                             const std::string& source) {
  if (bytes.empty()) {
    refuse(source + ": the picture is empty (0 bytes); check the camera's card");
  }
  refuse_text(bytes, source);
  ImageHeader header;
  try {
    header = require_intact_image(std::as_bytes(std::span(bytes)), source);
  } catch (const Error& error) {
    refuse(fmt::format("{}; it has {} bytes: check the camera's card and its connection",
                       error.what(), bytes.size()));
  }
  if (expected.width > 0 && header.size != expected) {
    refuse(fmt::format(
        "{}: the picture is {}x{}, but this session's are {}x{}; set the camera to "
        "that size",
        source, header.size.width, header.size.height, expected.width, expected.height));
  }
  return {header.format == ImageFormat::kJpeg ? "jpg" : "png", header.size};
}

}  // namespace raywalk::capture
