#include "core/files/gpano.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <string_view>

namespace raywalk {
namespace {

// XMP stands before the pixels.
std::string_view beginning_of(std::span<const std::byte> file) {
  constexpr std::size_t kBeginning = std::size_t{1} << 18;
  return {reinterpret_cast<const char*>(file.data()), std::min(file.size(), kBeginning)};
}

// "PosePitchDegrees" as an attribute or as an element.
std::optional<double> xmp_number(std::string_view text, std::string_view name) {
  const std::size_t at = text.find(name);
  if (at == std::string_view::npos) return std::nullopt;
  constexpr std::size_t kLongest = 40;
  const std::string rest(text.substr(at + name.size(), kLongest));
  const std::size_t begin = rest.find_first_not_of("= \"'>");
  if (begin == std::string::npos) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(rest.c_str() + begin, &end);
  if (end == rest.c_str() + begin || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<StatedAttitude> stated_attitude(std::span<const std::byte> file) {
  const std::string_view text = beginning_of(file);
  const auto pitch = xmp_number(text, "PosePitchDegrees");
  const auto roll = xmp_number(text, "PoseRollDegrees");
  if (!pitch && !roll) return std::nullopt;
  return StatedAttitude{pitch.value_or(0.0), roll.value_or(0.0)};
}

bool is_stated_as_cropped(std::span<const std::byte> file) {
  const std::string_view text = beginning_of(file);
  const auto is_less = [&](std::string_view part, std::string_view whole) {
    const auto pixels = xmp_number(text, part), all = xmp_number(text, whole);
    return pixels && all && *pixels < *all;
  };
  return is_less("CroppedAreaImageWidthPixels", "FullPanoWidthPixels") ||
         is_less("CroppedAreaImageHeightPixels", "FullPanoHeightPixels");
}

}  // namespace raywalk
