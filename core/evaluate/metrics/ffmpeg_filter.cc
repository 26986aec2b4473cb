#include "core/evaluate/metrics/ffmpeg_filter.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <stdexcept>

namespace raywalk {
namespace {

// A new directory that is removed with its contents.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "raywalk-metrics-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
    path_ = name;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Writes the image as one raw frame and returns the ffmpeg arguments that read it.
std::string raw_input(const cv::Mat& image, const std::filesystem::path& file) {
  const cv::Mat frame = image.isContinuous() ? image : image.clone();
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(frame.data),
            static_cast<std::streamsize>(frame.total() * frame.elemSize()));
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
  return std::string(" -f rawvideo -pix_fmt ") + (frame.channels() == 1 ? "gray" : "bgr24") +
         " -s " + std::to_string(frame.cols) + "x" + std::to_string(frame.rows) + " -i '" +
         file.string() + "'";
}

std::string output_of(const std::string& command) {
  // The command consists of constants and our own file names.
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");  // NOLINT(cert-env33-c)
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string output;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) {
    output += buffer.data();
  }
  if (pclose(pipe) != 0) throw std::runtime_error(command + " failed: " + output);
  return output;
}

}  // namespace

double ffmpeg_filter_value(const std::string& filter, const std::string& key, const cv::Mat& a,
                           const cv::Mat& b, const std::string& options) {
  const TemporaryDirectory directory;
  const std::string inputs =
      raw_input(a, directory.path() / "a.raw") + raw_input(b, directory.path() / "b.raw");
  const std::string output = output_of("ffmpeg -hide_banner -nostdin " + options + inputs +
                                       " -lavfi " + filter + " -f null -");
  std::smatch match;
  if (!std::regex_search(output, match, std::regex(" " + key + ":(-?[0-9.]+|inf)"))) {
    throw std::runtime_error("ffmpeg's " + filter + " prints no " + key + ": " + output);
  }
  return std::stod(match[1]);
}

}  // namespace raywalk
