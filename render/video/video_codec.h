// How a video is coded, as named on the command line.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace raywalk::render {

enum class VideoCodec { kH264, kH265, kAv1, kProRes };

// "h264", ...: the values of --codec.
extern const std::map<std::string, VideoCodec> kVideoCodecs;

struct VideoSettings {
  VideoCodec codec = VideoCodec::kH264;
  double fps = 30.0;         // frames per second, 1 to 240
  std::optional<int> crf{};  // none: the codec's default
};

// ".mp4", for ProRes ".mov".
std::string video_extension(VideoCodec codec);

// Throws UsageError where the file's extension is not the codec's, the codec takes no --crf or not
// that one, or fps is out of range.
void require_video_settings(const VideoSettings& settings, const std::filesystem::path& file);

// ffmpeg's arguments between its input and its output: the encoder, its quality and the colours.
// Colours are those of BT.709 in limited range, and the file says so.
std::vector<std::string> codec_arguments(const VideoSettings& settings);

// "H.264, crf 18", for summaries.
std::string codec_text(const VideoSettings& settings);

}  // namespace raywalk::render
