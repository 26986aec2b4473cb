// For tests: the generations of views.
#pragma once

#include "core/view/view_options.h"

namespace raywalk {

inline constexpr Generation kGenerations[] = {Generation::kInitial, Generation::kHlfVd,
                                              Generation::kTwoSided};
inline constexpr Generation kCorrected[] = {Generation::kHlfVd, Generation::kTwoSided};

}  // namespace raywalk
