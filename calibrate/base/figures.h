// Images of the report of a calibration. Each is named in the JSON of its step, in a list
// "figures" of {"row", "caption", "file"}: those of a row are shown side by side.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <string>

namespace raywalk::calibrate {

// `file`: relative to OUT.
nlohmann::ordered_json figure_json(const std::string& row, const std::string& caption,
                                   const std::filesystem::path& file);

// Writes `image` as OUT/figures/NAME.png, shrunk to what a page shows. `name` begins with that of
// the step, so that it is one of its outputs. Throws Error if the file cannot be written.
nlohmann::ordered_json write_figure(const std::filesystem::path& out, const std::string& name,
                                    const std::string& row, const std::string& caption,
                                    const cv::Mat& image);

}  // namespace raywalk::calibrate
