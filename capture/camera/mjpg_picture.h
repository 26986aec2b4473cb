// JPEG files from the frames of a motion-JPEG camera.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace raywalk::capture {

// The frame as a JPEG file that every decoder reads. Motion-JPEG may omit the Huffman tables (the
// AVI1 convention, followed by the USB video class) and then uses the standard tables of ITU-T T.81
// annex K.3; these are inserted before the first scan. None if the markers up to the first scan are
// not those of a JPEG.
std::optional<std::string> jpeg_from_mjpg(std::span<const std::byte> frame);

}  // namespace raywalk::capture
