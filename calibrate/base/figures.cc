#include "calibrate/base/figures.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

constexpr int kMostWidth_px = 1600;

}  // namespace

nlohmann::ordered_json figure_json(const std::string& row, const std::string& caption,
                                   const std::filesystem::path& file) {
  return {{"row", row}, {"caption", caption}, {"file", file.generic_string()}};
}

nlohmann::ordered_json write_figure(const std::filesystem::path& out, const std::string& name,
                                    const std::string& row, const std::string& caption,
                                    const cv::Mat& image) {
  cv::Mat shown = image;
  if (image.cols > kMostWidth_px) {
    const double scale = static_cast<double>(kMostWidth_px) / image.cols;
    cv::resize(image, shown, {}, scale, scale, cv::INTER_AREA);
  }
  make_directories(out / "figures");
  const std::filesystem::path file = std::filesystem::path("figures") / (name + ".png");
  write_image(out / file, shown);
  return figure_json(row, caption, file);
}

}  // namespace raywalk::calibrate
