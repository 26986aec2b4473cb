#include "core/report/report.h"

#include <openssl/evp.h>

#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/report/report_template.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kJpegQuality = 90;

std::string base64(const std::vector<unsigned char>& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // and the NUL that is written
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), bytes.data(),
                  static_cast<int>(bytes.size()));
  text.pop_back();
  return text;
}

// No markup in a text of the document may end the element that it stands in.
std::string inside_script(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) text += c == '<' ? "\\u003c" : std::string_view(&c, 1);
  return text;
}

}  // namespace

ReportImage report_image(std::string_view section, std::string_view row, std::string_view caption,
                         const cv::Mat& image) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    throw Error("report: an image must be 8-bit grey or colour and not empty");
  }
  std::vector<unsigned char> file;
  cv::imencode(".jpg", image, file, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return {.section = std::string(section),
          .row = std::string(row),
          .caption = std::string(caption),
          .source = "data:image/jpeg;base64," + base64(file)};
}

std::string report_page(std::string_view kind, const Json& document,
                        std::span<const ReportImage> images) {
  Json report{{"kind", kind},
              {"document", document},
              {"images", Json::array()},
              {"sources", Json::array()}};
  // An image that several rows show is written once.
  std::map<std::string_view, std::size_t> sources;
  for (const ReportImage& image : images) {
    const auto [source, is_new] = sources.emplace(image.source, sources.size());
    if (is_new) report["sources"].push_back(image.source);
    report["images"].push_back({{"section", image.section},
                                {"row", image.row},
                                {"caption", image.caption},
                                {"source", source->second}});
  }
  constexpr std::string_view kMark = "RAYWALK_REPORT";
  std::string page(report_template(kind));
  page.replace(page.find(kMark), kMark.size(),
               inside_script(report.dump(-1, ' ', false, Json::error_handler_t::replace)));
  return page;
}

}  // namespace raywalk
