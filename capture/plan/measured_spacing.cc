#include "capture/plan/measured_spacing.h"

#include <algorithm>
#include <cmath>

#include "core/files/csv.h"
#include "measured_spacing_table.h"

namespace raywalk::capture {
namespace {

// None outside of what was measured.
std::optional<MeasuredSpacing> at_share(const MeasuredRoom& room, double share) {
  // A share that differs from an end by rounding counts as measured.
  constexpr double kSame = 1e-6;
  const auto& spacings = room.spacings;
  if (share < spacings.front().spacing_share * (1.0 - kSame)) return std::nullopt;
  if (share > spacings.back().spacing_share * (1.0 + kSame)) return std::nullopt;
  const auto above =
      std::find_if(spacings.begin(), spacings.end(),
                   [&](const MeasuredSpacing& each) { return each.spacing_share >= share; });
  if (above == spacings.end()) return spacings.back();
  if (above == spacings.begin()) return spacings.front();
  const MeasuredSpacing& low = *(above - 1);
  const double part =
      std::log(share / low.spacing_share) / std::log(above->spacing_share / low.spacing_share);
  return MeasuredSpacing{share, std::lerp(low.mean_db, above->mean_db, part),
                         std::lerp(low.worst_db, above->worst_db, part)};
}

void include(double value, std::optional<DecibelRange>* range) {
  if (!*range) *range = DecibelRange{value, value};
  (*range)->least = std::min((*range)->least, value);
  (*range)->most = std::max((*range)->most, value);
}

}  // namespace

std::vector<MeasuredRoom> parse_measured_rooms(std::string_view text, const std::string& source) {
  const CsvTable table = CsvTable::parse(
      text, source, {"room", "spacing_mm", "nearest_m", "two_sided_db", "two_sided_worst_db"},
      {"panorama_width_px", "stations", "median_m", "hlf_vd_db", "hlf_vd_worst_db"});
  std::vector<MeasuredRoom> rooms;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string name = table.text(row, "room");
    if (rooms.empty() || rooms.back().name != name) rooms.push_back({name, {}});
    rooms.back().spacings.push_back(
        {1e-3 * table.number(row, "spacing_mm") / table.number(row, "nearest_m"),
         table.number(row, "two_sided_db"), table.number(row, "two_sided_worst_db")});
  }
  for (MeasuredRoom& room : rooms) {
    std::ranges::sort(room.spacings, {}, &MeasuredSpacing::spacing_share);
  }
  return rooms;
}

const std::vector<MeasuredRoom>& measured_rooms() {
  static const std::vector<MeasuredRoom> rooms =
      parse_measured_rooms(kMeasuredSpacingTable, "measured_spacing.csv");
  return rooms;
}

std::optional<ExpectedQuality> expected_quality(const std::vector<MeasuredRoom>& rooms,
                                                double spacing_share) {
  std::optional<DecibelRange> mean, worst, gained, lost;
  int measured = 0;
  for (const MeasuredRoom& room : rooms) {
    const auto here = at_share(room, spacing_share);
    if (!here) continue;
    ++measured;
    include(here->mean_db, &mean);
    include(here->worst_db, &worst);
    if (const auto half = at_share(room, 0.5 * spacing_share)) {
      include(half->mean_db - here->mean_db, &gained);
    }
    if (const auto twice = at_share(room, 2.0 * spacing_share)) {
      include(here->mean_db - twice->mean_db, &lost);
    }
  }
  if (!mean) return std::nullopt;
  return ExpectedQuality{spacing_share, measured, *mean, worst->least, gained, lost};
}

MeasuredShares measured_shares(const std::vector<MeasuredRoom>& rooms) {
  MeasuredShares shares{rooms.front().spacings.front().spacing_share, 0.0};
  for (const MeasuredRoom& room : rooms) {
    shares.least = std::min(shares.least, room.spacings.front().spacing_share);
    shares.most = std::max(shares.most, room.spacings.back().spacing_share);
  }
  return shares;
}

}  // namespace raywalk::capture
