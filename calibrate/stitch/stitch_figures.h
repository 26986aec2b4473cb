// The images of the report: a sample panorama of a capture, and its seam before and after.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

namespace raywalk::calibrate {

// One frame stitched with and without correction, CV_8UC3.
struct StitchSample {
  std::string station{};
  cv::Mat panorama{};    // balanced and blended
  cv::Mat unbalanced{};  // neither balanced nor blended
};

// Writes them into OUT/figures; returns the list for stitch.json (figures.h).
nlohmann::ordered_json write_stitch_figures(const StitchSample& sample,
                                            const std::filesystem::path& out);

// Whether all of them are there.
bool has_stitch_figures(const std::filesystem::path& out);

}  // namespace raywalk::calibrate
