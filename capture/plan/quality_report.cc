#include "capture/plan/quality_report.h"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/base/units.h"

namespace raywalk::capture {
namespace {

constexpr const char* kSource = "docs/spacing.md has the measured rooms; yours may differ";

std::string range_text(const DecibelRange& range) {
  const std::string least = fmt::format("{:.1f}", range.least);
  const std::string most = fmt::format("{:.1f}", range.most);
  return least == most ? least : fmt::format("{} to {}", least, most);
}

std::string outside_text(const QualityReport& report) {
  if (report.spacing_share < report.measured.least) {
    return fmt::format("           denser than any room that was measured (from {:.3f} on); {}\n",
                       report.measured.least, kSource);
  }
  return fmt::format("           sparser than any room that was measured (up to {:.2f}); {}\n",
                     report.measured.most, kSource);
}

std::string trade_text(const ExpectedQuality& expected) {
  std::string text;
  if (expected.lost_by_twice_db) {
    text += fmt::format("twice the spacing lost {} dB", range_text(*expected.lost_by_twice_db));
  }
  if (expected.gained_by_half_db) {
    text += fmt::format("{}half of it gained {} dB", text.empty() ? "" : ", ",
                        range_text(*expected.gained_by_half_db));
  }
  return text.empty() ? text : text + "; ";
}

nlohmann::json range_json(const std::optional<DecibelRange>& range) {
  if (!range) return {};
  return {{"least", range->least}, {"most", range->most}};
}

}  // namespace

std::optional<QualityReport> quality_report(double spacing_mm, double nearest_m,
                                            const std::vector<MeasuredRoom>& rooms) {
  if (nearest_m <= 0.0 || rooms.empty()) return std::nullopt;
  const double share = spacing_mm / kMillimetresPerMetre / nearest_m;
  return QualityReport{share, measured_shares(rooms), expected_quality(rooms, share)};
}

std::string quality_text(const std::optional<QualityReport>& report) {
  if (!report) {
    return "quality:   set scene.nearest_m to compare the spacing with rooms that were measured\n";
  }
  std::string text = fmt::format(
      "quality:   the stations are {:.2g} of the distance to the nearest surface apart\n",
      report->spacing_share);
  if (!report->expected) return text + outside_text(*report);
  const ExpectedQuality& expected = *report->expected;
  text += fmt::format(
      "           {} captured like this, with distances from the photographs alone: two-sided "
      "views of {} dB, the worst {:.1f}\n",
      counted(static_cast<std::size_t>(expected.rooms), "room"), range_text(expected.mean_db),
      expected.worst_db);
  return text + fmt::format("           {}{}\n", trade_text(expected), kSource);
}

nlohmann::json quality_json(const std::optional<QualityReport>& report) {
  if (!report) return {};
  nlohmann::json json{{"spacing_over_nearest", report->spacing_share},
                      {"measured_from", report->measured.least},
                      {"measured_to", report->measured.most},
                      {"source", "docs/spacing.md"},
                      {"rooms", 0},
                      {"two_sided_db", nullptr},
                      {"worst_db", nullptr},
                      {"gained_by_half_db", nullptr},
                      {"lost_by_twice_db", nullptr}};
  if (report->expected) {
    json["rooms"] = report->expected->rooms;
    json["two_sided_db"] = range_json(report->expected->mean_db);
    json["worst_db"] = report->expected->worst_db;
    json["gained_by_half_db"] = range_json(report->expected->gained_by_half_db);
    json["lost_by_twice_db"] = range_json(report->expected->lost_by_twice_db);
  }
  return json;
}

}  // namespace raywalk::capture
