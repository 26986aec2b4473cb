// JPEG files from the frames of a motion-JPEG camera.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace raywalk::capture {

// The frame as a JPEG file that every decoder reads. Motion-JPEG may leave out the Huffman tables
// (the AVI1 convention, which the USB video class follows): then the standard ones of ITU-T T.81
// annex K.3, which such a frame is coded with, are put before its first scan. None where the
// markers up to there are not those of a JPEG.
std::optional<std::string> jpeg_from_mjpg(std::span<const std::byte> frame);

}  // namespace raywalk::capture
