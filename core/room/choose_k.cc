#include "core/room/choose_k.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace raywalk {
namespace {

// Generations whose measurement is used, in order of preference.
std::vector<std::string> measurements_for(const std::string& generation) {
  if (generation == "initial") return {"initial"};
  return {generation, generation == "hlf-vd" ? "two-sided" : "hlf-vd", "initial"};
}

std::string why_unusable(const ConnectionErrorMeasurement& measurement) {
  if (measurement.rows.size() < 2) return "connect-error measured only one k";
  if (std::isnan(measurement.common_share)) {
    return "connect-error does not say how many corners it compared; measure again";
  }
  return fmt::format("connect-error could compare only {:.0f} % of the corners at every k",
                     100.0 * measurement.common_share);
}

}  // namespace

ChosenK choose_k(std::span<const ConnectionErrorMeasurement> measurements,
                 const std::string& generation) {
  std::string reason = "not measured on this room";
  bool any = false;
  for (const std::string& wanted : measurements_for(generation)) {
    const auto found =
        std::ranges::find(measurements, wanted, &ConnectionErrorMeasurement::generation);
    if (found == measurements.end()) continue;
    if (const auto least = least_error(*found)) {
      return {least->k_deg, "measured E_connect of " + wanted + " views"};
    }
    if (!any) reason = why_unusable(*found);
    any = true;
  }
  return {kUnmeasuredKDeg,
          reason + fmt::format("; {:g} is best on the rooms measured so far", kUnmeasuredKDeg)};
}

ChosenK choose_k(const Room& room, const std::string& generation) {
  if (room.grid().cells.empty()) return {kUnmeasuredKDeg, "the room has no connections"};
  return choose_k(read_connection_errors(room.directory()), generation);
}

}  // namespace raywalk
