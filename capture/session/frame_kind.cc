#include "capture/session/frame_kind.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstddef>
#include <span>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/gpano.h"
#include "core/panorama/picture_look.h"

namespace raywalk::capture {
namespace {

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

void require_frame_kind(const std::string& bytes, FrameKind configured, const std::string& name) {
  const auto picture = std::as_bytes(std::span(bytes));
  const PictureKind seen = look_at_picture(picture);
  if (seen == PictureKind::kDualFisheye && configured == FrameKind::kPanorama) {
    throw Error(fmt::format(
        "{} shows two fisheye circles, but camera.frames is panorama; set the camera to stitch "
        "its pictures, or begin a session with camera.frames: dual-fisheye",
        name));
  }
  if (seen == PictureKind::kPanorama && configured == FrameKind::kDualFisheye) {
    throw Error(fmt::format(
        "{} shows a stitched panorama, but camera.frames is dual-fisheye; set the camera not to "
        "stitch its pictures, or begin a session with camera.frames: panorama",
        name));
  }
  warn_unless_upright(picture, name);
}

}  // namespace raywalk::capture
