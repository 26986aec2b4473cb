// What a video's file says of itself: an MP4 or QuickTime file (ISO/IEC 14496-12) as ffmpeg writes
// it. It consists of boxes: a size of 4 bytes, a type of four letters, and a content that for some
// types is boxes again. "moov" describes the tracks, "mdat" holds their frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace raywalk::render {

// Which picture of a frame each eye sees.
enum class StereoMode { kMono, kTopBottom };  // top: the left eye

// What is written into every video, to know it again.
inline constexpr const char* kVideoComment = "made by raywalk-render path";

struct VideoFacts {
  std::int64_t frames = 0;
  int width = 0;
  int height = 0;
  std::optional<StereoMode> stereo{};  // of a panorama of the whole sphere; none: flat
  bool by_raywalk = false;
};

// Of the first track of pictures. Throws Error naming the file: missing, not a video, cut short,
// damaged.
VideoFacts read_video(const std::filesystem::path& file);

// Bytes that have to be free behind the description for set_spherical().
inline constexpr std::int64_t kSphericalBytes = 4096;

// Says in a video that its frames are panoramas of the whole sphere whose middle looks forward, by
// Google's "Spherical Video V2 RFC" (boxes st3d and sv3d of the track's pictures) and the older
// "Spherical Video RFC" (XMP in a box uuid of the track),
// https://github.com/google/spatial-media/blob/master/docs
// The description grows into the free box behind it, so that no frame moves. `name` is what
// messages call the video. Throws Error as read_video, or where there is not enough that is free.
void set_spherical(const std::filesystem::path& file, StereoMode stereo, const std::string& name);

}  // namespace raywalk::render
