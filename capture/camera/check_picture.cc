#include "capture/camera/check_picture.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <span>

#include "capture/base/device_fault.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/gpano.h"
#include "core/files/image_file.h"
#include "core/panorama/picture_look.h"

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

void warn_unless_upright(std::span<const std::byte> picture, const std::string& name) {
  constexpr double kMost_deg = 5.0;  // of a camera that was meant to be upright
  const auto attitude = stated_attitude(picture);
  if (!attitude) return;
  if (std::abs(attitude->pitch_deg) <= kMost_deg && std::abs(attitude->roll_deg) <= kMost_deg) {
    return;
  }
  spdlog::warn(
      "{}: its metadata state a pitch of {:.0f} and a roll of {:.0f} degrees, which no panorama of "
      "Raywalk follows: set the camera upright, or let raywalk-calibrate estimate its attitude",
      escaped(name), attitude->pitch_deg, attitude->roll_deg);
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

void require_frame_kind(const std::string& bytes, FrameKind configured, const std::string& name) {
  const auto picture = std::as_bytes(std::span(bytes));
  const bool stitched = configured == FrameKind::kPanorama;
  if (look_at_picture(picture) == (stitched ? PictureKind::kDualFisheye : PictureKind::kPanorama)) {
    throw Error(fmt::format(
        "{} shows {}, but camera.frames is {}; set the camera {} its pictures, or begin a session "
        "with camera.frames: {}",
        name, stitched ? "two fisheye circles" : "a stitched panorama", name_of(configured),
        stitched ? "to stitch" : "not to stitch",
        name_of(stitched ? FrameKind::kDualFisheye : FrameKind::kPanorama)));
  }
  warn_unless_upright(picture, name);
}

}  // namespace raywalk::capture
