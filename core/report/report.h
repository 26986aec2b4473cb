// Reports: one HTML file that draws itself from a JSON document, with the images it shows inside,
// and asks nothing of a host. How a kind is drawn is described in TypeScript (<kind>.ts) beside the
// C++ that supplies the values.
//
//   std::vector<ReportImage> images{report_image("views", "view free_a", "truth", picture)};
//   write_file_atomically(dir / "index.html", report_page("validation", document, images));
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>

namespace raywalk {

// An image as the page shows it: those of a row stand side by side and are zoomed into together.
struct ReportImage {
  std::string section{};  // where the page shows it
  std::string row{};      // what the images of a row show, e.g. "view free_a"
  std::string caption{};  // what distinguishes it in its row, e.g. "truth"
  std::string source{};   // a data URI
};

// As JPEG. Throws Error unless the image is 8-bit, grey or BGR, and not empty.
ReportImage report_image(std::string_view section, std::string_view row, std::string_view caption,
                         const cv::Mat& image);

// The complete page. `kind`: the stem of a description, e.g. "error_model". Numbers that are not
// finite read as not measured; bytes that are not UTF-8, e.g. in the name of a file, are replaced.
std::string report_page(std::string_view kind, const nlohmann::ordered_json& document,
                        std::span<const ReportImage> images = {});

}  // namespace raywalk
