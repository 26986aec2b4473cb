// What views of rooms lost as their stations were spaced more widely, as measured by
// scripts/measure-spacing, for the choice of a plan's spacing. docs/spacing.md has the figures.
//
// Rooms of different size are compared at the same spacing relative to the distance of their
// nearest surfaces (the nearest hundredth of all directions): the parallax from station to station
// that the estimation of distances and the filling of hidden places must bridge. It has no unit.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk::capture {

struct MeasuredSpacing {
  double spacing_share = 0.0;  // spacing over the distance of the nearest surfaces
  double mean_db = 0.0;        // PSNR of two-sided views with distances from the photographs alone
  double worst_db = 0.0;       // of the worst view
};

struct MeasuredRoom {
  std::string name;
  std::vector<MeasuredSpacing> spacings;  // at least one, by increasing share
};

// Of a table as scripts/measure-spacing writes it; `source` names it in errors. Throws Error if it
// cannot be read.
std::vector<MeasuredRoom> parse_measured_rooms(std::string_view table, const std::string& source);

// The table that the program was built with.
const std::vector<MeasuredRoom>& measured_rooms();

struct DecibelRange {
  double least = 0.0;
  double most = 0.0;
};

// What rooms had at a spacing, interpolated over the logarithm of the share.
struct ExpectedQuality {
  double spacing_share = 0.0;
  int rooms = 0;  // that were measured on both sides of this share
  DecibelRange mean_db{};
  double worst_db = 0.0;
  // What those rooms had more at half the spacing and less at twice it; none if no room was
  // measured there.
  std::optional<DecibelRange> gained_by_half_db{};
  std::optional<DecibelRange> lost_by_twice_db{};
};

// None if no room was measured at `spacing_share`, which must be positive.
std::optional<ExpectedQuality> expected_quality(const std::vector<MeasuredRoom>& rooms,
                                                double spacing_share);

// The least and the largest share at which any room was measured. `rooms` must not be empty.
struct MeasuredShares {
  double least = 0.0;
  double most = 0.0;
};
MeasuredShares measured_shares(const std::vector<MeasuredRoom>& rooms);

}  // namespace raywalk::capture
