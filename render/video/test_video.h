// For tests: videos as ffprobe and ffmpeg see them.
#pragma once

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace raywalk::render {

inline std::string printed_by(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string output;
  std::array<char, 65536> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    output.append(buffer.data(), count);
  }
  if (pclose(pipe) != 0) throw std::runtime_error(command + " failed");
  return output;
}

// The only stream of a video.
inline nlohmann::json video_stream(const std::filesystem::path& file) {
  const auto found = nlohmann::json::parse(
      printed_by("ffprobe -v error -of json -show_streams '" + file.string() + "'"));
  return found.at("streams").size() == 1 ? found.at("streams")[0] : nlohmann::json();
}

inline nlohmann::json side_data(const nlohmann::json& stream, const std::string& type) {
  for (const auto& data : stream.value("side_data_list", nlohmann::json::array())) {
    if (data.value("side_data_type", "") == type) return data;
  }
  return nlohmann::json::object();
}

// Its frames, CV_8UC3 in BGR order.
inline std::vector<cv::Mat> video_frames(const std::filesystem::path& file, cv::Size size) {
  const std::string bytes =
      printed_by("ffmpeg -v error -nostdin -i '" + file.string() +
                 "' -sws_flags accurate_rnd+full_chroma_int -f rawvideo -pix_fmt bgr24 -");
  const auto frame_bytes = static_cast<std::size_t>(3 * size.area());
  std::vector<cv::Mat> frames;
  for (std::size_t at = 0; at + frame_bytes <= bytes.size(); at += frame_bytes) {
    cv::Mat frame(size, CV_8UC3);
    std::copy_n(bytes.data() + at, frame_bytes, frame.data);
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace raywalk::render
