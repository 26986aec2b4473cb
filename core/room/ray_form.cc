#include "core/room/ray_form.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "core/base/error.h"

namespace raywalk {

RayForm ray_form_from_name(const std::string& name) {
  if (name == "none") return {};
  if (name == "lossless") return {RayForm::Kind::kLossless, 0};
  constexpr std::string_view kJpegPrefix = "jpeg:";
  if (name.starts_with(kJpegPrefix)) {
    const char* const end = name.data() + name.size();
    int quality = 0;
    const auto [rest, error] = std::from_chars(name.data() + kJpegPrefix.size(), end, quality);
    if (error == std::errc() && rest == end && quality >= 1 && quality <= 100) {
      return {RayForm::Kind::kJpeg, quality};
    }
  }
  throw UsageError(fmt::format(
      "no such compression: {}; give none, lossless, or jpeg:Q with a quality Q from 1 to 100",
      excerpt(name)));
}

std::uint64_t estimated_bytes(const RayForm& form, std::uint64_t raw_bytes) {
  switch (form.kind) {
    case RayForm::Kind::kLossless:
      return raw_bytes / 10 * 7;
    case RayForm::Kind::kJpeg:
      return form.jpeg_quality > 95 ? raw_bytes / 2 : raw_bytes / 4;
    case RayForm::Kind::kRaw:
      break;
  }
  return raw_bytes;
}

std::string name_of(const RayForm& form) {
  switch (form.kind) {
    case RayForm::Kind::kLossless:
      return "lossless";
    case RayForm::Kind::kJpeg:
      return fmt::format("jpeg:{}", form.jpeg_quality);
    case RayForm::Kind::kRaw:
      break;
  }
  return "none";
}

}  // namespace raywalk
