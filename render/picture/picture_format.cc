#include "render/picture/picture_format.h"

#include <algorithm>
#include <cctype>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

std::string in_lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_one_of(const std::string& text, std::initializer_list<const char*> others) {
  return std::find(others.begin(), others.end(), text) != others.end();
}

}  // namespace

PictureFormat picture_format(const std::filesystem::path& file, const PictureFlags& flags) {
  PictureFormat format{.extension = in_lower_case(file.extension().string()),
                       .quality = flags.quality};
  const bool is_tiff = is_one_of(format.extension, {".tif", ".tiff"});
  const bool is_lossy = is_one_of(format.extension, {".jpg", ".jpeg", ".webp"});
  if (!is_tiff && !is_lossy && format.extension != ".png") {
    throw UsageError("cannot write " + file.string() +
                     ": the name must end in .png, .jpg, .webp or .tif");
  }
  if (flags.quality && !is_lossy) {
    throw UsageError("--quality is for .jpg and .webp; " + format.extension +
                     " keeps every pixel as it is");
  }
  format.bits = flags.bits.value_or(is_tiff ? 16 : 8);
  if (format.bits == 16 && is_lossy) {
    throw UsageError("--bits 16 is for .png and .tif; " + format.extension + " has 8");
  }
  return format;
}

}  // namespace raywalk::render
