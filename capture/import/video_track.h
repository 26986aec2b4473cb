// The frames of a video in order, each with its time; motion and sharpness of every one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace raywalk::capture {

struct DecodedFrame {
  std::size_t number = 0;  // from 0
  double time_s = 0.0;     // since the first frame; ascending
  cv::Mat picture{};       // CV_8UC3, BGR
};

// Decodes a video with OpenCV's VideoCapture and calls `visit` with every frame, until it returns
// false. Throws Error naming the file if it is missing or not a video, no frame can be decoded, a
// frame has no time, or a frame differs in size from the first; Interrupted.
void read_video(const std::filesystem::path& video,
                const std::function<bool(const DecodedFrame&)>& visit);

struct TrackFrame {
  double time_s = 0.0;     // since the first frame
  double activity = 0.0;   // mean change since the frame before, grey levels; 0 for the first
  double sharpness = 0.0;  // variance of the picture's Laplacian; lower is more blurred
};

struct VideoTrack {
  std::vector<TrackFrame> frames;
  cv::Size size{};
};

// Reads a video from start to end with one frame in memory at a time. Throws as read_video does.
VideoTrack track_video(const std::filesystem::path& video);

// One flag per frame: clearly less sharp than the frames within half a second around it.
std::vector<bool> blurred_frames(const VideoTrack& track);

}  // namespace raywalk::capture
