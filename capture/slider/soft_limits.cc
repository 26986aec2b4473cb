#include "capture/slider/soft_limits.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"

namespace raywalk::capture {

SoftLimits::SoftLimits(double low_mm, double high_mm) : low_mm_(low_mm), high_mm_(high_mm) {
  if (!std::isfinite(low_mm) || !std::isfinite(high_mm) || !(low_mm < high_mm)) {
    throw UsageError(fmt::format(
        "soft limits of {} to {} mm are empty; the low limit must be below the high one", low_mm,
        high_mm));
  }
}

SafePosition SoftLimits::require(double mm, const std::string& what) const {
  if (!contains(mm)) {
    throw UsageError(fmt::format("{}: {:.3f} mm is outside the soft limits, {} to {} mm", what, mm,
                                 low_mm_, high_mm_));
  }
  return SafePosition(mm);
}

}  // namespace raywalk::capture
