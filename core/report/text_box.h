// Where a text of a drawing is printed, to keep texts apart.
#pragma once

#include <cmath>
#include <string_view>

namespace raywalk {

inline constexpr double kFontPx = 13.0;

// Approximate printed width of a text, rather too large: the widest glyphs of common sans-serif
// fonts are those of digits and capitals, 0.64 of the font size.
inline double text_px(std::string_view text) {
  return 0.64 * kFontPx * static_cast<double>(text.size());
}

// The bounding box of a text, pixels.
struct TextBox {
  double left = 0.0;
  double right = 0.0;
  double baseline = 0.0;

  bool overlaps(const TextBox& other) const {
    return left < other.right && other.left < right &&
           std::abs(baseline - other.baseline) < kFontPx;
  }
};

}  // namespace raywalk
