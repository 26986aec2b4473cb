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
