#include "capture/slider/fake_slider_config.h"

#include <array>
#include <list>
#include <stdexcept>

#include "core/base/error.h"
#include "core/files/settings.h"

namespace raywalk::capture {
namespace {

constexpr double kFar_mm = 1e9;
constexpr double kLong_ms = 1e12;
constexpr std::size_t kMaxFaults = 1000;
constexpr std::array kFaultKinds{
    SliderFaultKind::kStall,    SliderFaultKind::kIgnore,    SliderFaultKind::kAlarm,
    SliderFaultKind::kLowLimit, SliderFaultKind::kHighLimit, SliderFaultKind::kNoContact,
    SliderFaultKind::kOutlier,  SliderFaultKind::kDrift,     SliderFaultKind::kRunaway};

SettingsSchema fault_schema(FakeSliderFault* fault) {
  SettingsSchema schema;
  schema.choice("kind", &fault->kind, kFaultKinds)
      .number("at_ms", &fault->at_ms, 0.0, kLong_ms)
      .number("at_mm", &fault->at_mm, -kFar_mm, kFar_mm)
      .number("for_ms", &fault->for_ms, 0.0, kLong_ms)
      .number("size_mm", &fault->size_mm, -kFar_mm, kFar_mm);
  return schema;
}

}  // namespace

std::string_view name_of(SliderFaultKind kind) {
  switch (kind) {
    case SliderFaultKind::kStall:
      return "stall";
    case SliderFaultKind::kIgnore:
      return "ignore";
    case SliderFaultKind::kAlarm:
      return "alarm";
    case SliderFaultKind::kLowLimit:
      return "low-limit";
    case SliderFaultKind::kHighLimit:
      return "high-limit";
    case SliderFaultKind::kNoContact:
      return "no-contact";
    case SliderFaultKind::kOutlier:
      return "outlier";
    case SliderFaultKind::kDrift:
      return "drift";
    case SliderFaultKind::kRunaway:
      return "runaway";
  }
  throw std::logic_error("unknown kind of slider fault");
}

FakeSliderConfig parse_fake_slider_config(std::string_view yaml, const std::string& source) {
  FakeSliderConfig config;
  std::list<FakeSliderFault> faults;  // keeps the addresses that the schemas are bound to
  SettingsSchema schema;
  schema.number("most_speed_mm_s", &config.most_speed_mm_s, 1e-6, 1e6)
      .number("most_acceleration_mm_s2", &config.most_acceleration_mm_s2, 1e-6, 1e6)
      .number("backlash_mm", &config.backlash_mm, 0.0, kFar_mm)
      .number("noise_mm", &config.noise_mm, 0.0, kFar_mm)
      .integer("seed", &config.seed, 0, 2147483647)
      .number("start_mm", &config.start_mm, -kFar_mm, kFar_mm)
      .boolean("homed", &config.homed)
      .boolean("reports_flags", &config.reports_flags)
      .integer("alarm_code", &config.alarm_code, 0, 0xffff)
      .items(
          "faults", [&faults] { return fault_schema(&faults.emplace_back()); }, kMaxFaults);
  schema.parse(yaml, source);
  for (const FakeSliderFault& fault : faults) {
    if (fault.at_ms < 0.0 && fault.at_mm <= -kFar_mm) {
      throw UsageError(source + ": a fault '" + std::string(name_of(fault.kind)) +
                       "' has neither at_ms nor at_mm");
    }
  }
  config.faults.assign(faults.begin(), faults.end());
  return config;
}

}  // namespace raywalk::capture
