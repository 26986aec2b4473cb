// What a capture takes on the spot: days, storage cards and charges of the camera's battery.
//
// The facts about place and camera are settings. Where the configuration does not give one, what
// follows from it is unknown; nothing is assumed.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "capture/plan/capture_plan.h"
#include "capture/plan/capture_time.h"

namespace raywalk::capture {

// `pictures` and `picture_mb` of the whole plan and of one exposure, 10^6 bytes; none: unknown.
// Null for what is unknown.
nlohmann::ordered_json field_work(const CapturePlan& plan, const CaptureConfig& config,
                                  const CaptureTime& time, std::size_t pictures,
                                  const std::optional<double>& picture_mb);

}  // namespace raywalk::capture
