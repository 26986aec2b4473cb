// The report of `raywalk-capture plan`: one document, printed as JSON or text and drawn as a page
// (plan.ts).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/plan/capture_plan.h"
#include "capture/plan/capture_time.h"

namespace raywalk::capture {

using PlanJson = nlohmann::ordered_json;

// Of one exposure, 10^6 bytes; none if it cannot be estimated.
std::optional<double> picture_mb(const CaptureConfig& config);

// Stations, time, storage and resolution of a plan. Null for what the configuration leaves unknown.
PlanJson plan_report(const CapturePlan& plan, const CaptureConfig& config);

// Its part about days, storage cards and charges of the camera's battery, for so many pictures of
// this size. The facts about place and camera are settings: where the configuration does not give
// one, what follows from it is unknown; nothing is assumed.
PlanJson field_work(const CapturePlan& plan, const CaptureConfig& config, const CaptureTime& time,
                    std::size_t pictures, const std::optional<double>& picture_mb);

// The sentences of a report by subject, in order: {"lines": "4 lines, ...", "rail": ...}.
PlanJson plan_summary(const PlanJson& report);

// The summary as lines of text, warnings last.
std::string plan_report_text(const PlanJson& report);

}  // namespace raywalk::capture
