#include "core/view/view_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <span>

#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr std::array<const char*, 3> kGenerationNames{"initial", "hlf-vd", "two-sided"};
constexpr std::array<const char*, 3> kInterpolationNames{"nearest", "linear", "cubic"};
constexpr std::array<const char*, 2> kArithmeticNames{"float", "double"};
constexpr std::array<const char*, 2> kSecondSideNames{"blend", "where-hidden"};

std::size_t index_of(const std::string& name, std::span<const char* const> names,
                     const char* what) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return i;
  }
  throw UsageError(fmt::format("unknown {} '{}'; use {}", what, name, fmt::join(names, ", ")));
}

void require_between(double value, double least, double most, const char* what) {
  if (value >= least && value <= most) return;
  throw UsageError(fmt::format("{} is {}; it must be in {}..{}", what, value, least, most));
}

}  // namespace

std::string generation_name(Generation generation) {
  return kGenerationNames[static_cast<std::size_t>(generation)];
}

Generation generation_from_name(const std::string& name) {
  return static_cast<Generation>(index_of(name, kGenerationNames, "generation"));
}

std::string interpolation_name(Interpolation interpolation) {
  return kInterpolationNames[static_cast<std::size_t>(interpolation)];
}

Interpolation interpolation_from_name(const std::string& name) {
  return static_cast<Interpolation>(index_of(name, kInterpolationNames, "interpolation"));
}

std::string arithmetic_name(Arithmetic arithmetic) {
  return kArithmeticNames[static_cast<std::size_t>(arithmetic)];
}

Arithmetic arithmetic_from_name(const std::string& name) {
  return static_cast<Arithmetic>(index_of(name, kArithmeticNames, "arithmetic"));
}

std::string second_side_name(SecondSide second_side) {
  return kSecondSideNames[static_cast<std::size_t>(second_side)];
}

SecondSide second_side_from_name(const std::string& name) {
  return static_cast<SecondSide>(index_of(name, kSecondSideNames, "second side"));
}

void require_view_options(const ViewOptions& options) {
  require_between(options.k_deg, 45.0, 90.0, "k (degrees)");
  require_between(options.overlap_deg, 0.0, 45.0, "the overlap (degrees)");
  if (options.layers < 0) throw UsageError("the number of depth layers must not be negative");
  if (!(options.tolerance_px > 0.0 && std::isfinite(options.tolerance_px))) {
    throw UsageError(
        fmt::format("the tolerance is {} pixels; it must be positive", options.tolerance_px));
  }
  if (options.width < 4 || options.width > 32768 || options.width % 4 != 0) {
    throw UsageError(
        fmt::format("output width {} must be a multiple of 4 in 4..32768", options.width));
  }
  require_between(options.stations_mixed, 1, 2, "the number of stations mixed");
  if (options.station_stride < 1) throw UsageError("the station stride must be at least 1");
  require_between(options.distance_maps, 1, 4, "the number of distance maps");
  require_between(options.fill_stations, 0, 32, "the number of stations to fill from");
  require_between(options.skip_px, 0.0, 4.0, "skip_px");
}

}  // namespace raywalk
