#include "build_lf/depth/depth_steps.h"

#include <fmt/format.h>

#include <cstddef>

#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

constexpr std::array<const char*, kDepthSteps.size()> kNames{
    "links",  "reach", "surfaces", "colours", "sweep",
    "choose", "fuse",  "moved",    "volumes", "gains"};

}  // namespace

std::string name_of(DepthStep step) { return kNames.at(static_cast<std::size_t>(step)); }

std::string depth_step_names() {
  std::string names;
  for (const char* name : kNames) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

DepthStep depth_step_from_name(const std::string& name) {
  for (const DepthStep step : kDepthSteps) {
    if (name == name_of(step)) return step;
  }
  throw UsageError(fmt::format("unknown step '{}'; the steps are {}", name, depth_step_names()));
}

}  // namespace raywalk::build_lf
