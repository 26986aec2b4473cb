#include "render/view/picture_format.h"

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

PictureFormat picture_format(const std::filesystem::path& file, std::optional<int> quality) {
  PictureFormat format{.extension = in_lower_case(file.extension().string()), .quality = quality};
  const bool is_lossy = is_one_of(format.extension, {".jpg", ".jpeg", ".webp"});
  if (!is_lossy && !is_one_of(format.extension, {".png", ".tif", ".tiff"})) {
    throw UsageError("cannot write " + file.string() +
                     ": the name must end in .png, .jpg, .webp or .tif");
  }
  if (quality && !is_lossy) {
    throw UsageError("--quality is for .jpg and .webp; " + format.extension +
                     " keeps every pixel as it is");
  }
  return format;
}

}  // namespace raywalk::render
