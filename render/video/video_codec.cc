#include "render/video/video_codec.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

constexpr double kLeastFps = 1.0;
constexpr double kMostFps = 240.0;

// The default CRF is one at which videos of rooms are hard to tell from their frames. H.265 and AV1
// reach the same at other values, and on other scales.
struct Coding {
  const char* flag;
  const char* name;
  const char* extension;
  std::optional<int> crf;  // none: the codec has no such scale
  int most_crf;
  const char* pixels;
  std::vector<std::string> encoder;
};

const Coding& coding_of(VideoCodec codec) {
  static const std::map<VideoCodec, Coding> kCodings = {
      {VideoCodec::kH264,
       {"h264", "H.264", ".mp4", 18, 51, "yuv420p", {"-c:v", "libx264", "-preset", "medium"}}},
      // Players of Apple's expect the tag hvc1.
      {VideoCodec::kH265,
       {"h265",
        "H.265",
        ".mp4",
        20,
        51,
        "yuv420p",
        {"-c:v", "libx265", "-preset", "medium", "-tag:v", "hvc1", "-x265-params",
         "log-level=error"}}},
      {VideoCodec::kAv1,
       {"av1", "AV1", ".mp4", 28, 63, "yuv420p", {"-c:v", "libsvtav1", "-preset", "8"}}},
      {VideoCodec::kProRes,
       {"prores",
        "ProRes 422 HQ",
        ".mov",
        std::nullopt,
        0,
        "yuv422p10le",
        {"-c:v", "prores_ks", "-profile:v", "hq", "-vendor", "apl0"}}}};
  return kCodings.at(codec);
}

int crf_of(const VideoSettings& settings) {
  return settings.crf.value_or(coding_of(settings.codec).crf.value_or(0));
}

}  // namespace

const std::map<std::string, VideoCodec> kVideoCodecs = {{"h264", VideoCodec::kH264},
                                                        {"h265", VideoCodec::kH265},
                                                        {"av1", VideoCodec::kAv1},
                                                        {"prores", VideoCodec::kProRes}};

std::string video_extension(VideoCodec codec) { return coding_of(codec).extension; }

void require_video_settings(const VideoSettings& settings, const std::filesystem::path& file) {
  const Coding& coding = coding_of(settings.codec);
  if (file.extension() != coding.extension) {
    throw UsageError(
        fmt::format("{}: videos of {} end in {}; {}", file.string(), coding.name, coding.extension,
                    file.extension() == ".mov" ? "give --codec prores for .mov"
                                               : "name the file so, or give another --codec"));
  }
  if (settings.crf && !coding.crf) {
    throw UsageError(fmt::format("--crf: {} has a fixed quality; leave it out", coding.name));
  }
  if (settings.crf && (*settings.crf < 0 || *settings.crf > coding.most_crf)) {
    throw UsageError(fmt::format("--crf is {}; for --codec {} it is 0 to {}", *settings.crf,
                                 coding.flag, coding.most_crf));
  }
  if (!(settings.fps >= kLeastFps && settings.fps <= kMostFps)) {
    throw UsageError(fmt::format("--fps is {:g}; give {:g} to {:g} frames per second", settings.fps,
                                 kLeastFps, kMostFps));
  }
}

std::vector<std::string> codec_arguments(const VideoSettings& settings) {
  const Coding& coding = coding_of(settings.codec);
  // setparams: some encoders write what the frames say of their colours, others what the options
  // say.
  std::vector<std::string> arguments = {
      "-vf",
      fmt::format("scale=in_range=full:out_range=limited:out_color_matrix=bt709:"
                  "flags=bicubic+accurate_rnd+full_chroma_int,format={},setparams=range=limited:"
                  "colorspace=bt709:color_primaries=bt709:color_trc=bt709",
                  coding.pixels),
      "-color_range",
      "tv",
      "-colorspace",
      "bt709",
      "-color_primaries",
      "bt709",
      "-color_trc",
      "bt709"};
  arguments.insert(arguments.end(), coding.encoder.begin(), coding.encoder.end());
  if (coding.crf) {
    arguments.insert(arguments.end(), {"-crf", std::to_string(crf_of(settings))});
  }
  return arguments;
}

std::string codec_text(const VideoSettings& settings) {
  const Coding& coding = coding_of(settings.codec);
  return coding.crf ? fmt::format("{}, crf {}", coding.name, crf_of(settings)) : coding.name;
}

}  // namespace raywalk::render
