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

std::string name_of(const RayForm& form) {
  if (form.kind == RayForm::Kind::kJpeg) return fmt::format("jpeg:{}", form.jpeg_quality);
  return form.compressed() ? "lossless" : "none";
}

std::uint64_t estimated_bytes(const RayForm& form, std::uint64_t raw_bytes) {
  if (!form.compressed()) return raw_bytes;
  if (form.kind == RayForm::Kind::kLossless) return raw_bytes / 10 * 7;
  return form.jpeg_quality > 95 ? raw_bytes / 2 : raw_bytes / 4;
}

}  // namespace raywalk
