#include "calibrate/rectify/crossing_table.h"

#include <fmt/format.h>

#include "core/report/markup.h"

namespace raywalk::calibrate {
std::string crossing_name(const CaptureSet& set, int along_x, int along_z) {
  return fmt::format("{} / {}", set.lines[static_cast<std::size_t>(along_x)].id,
                     set.lines[static_cast<std::size_t>(along_z)].id);
}

HtmlTable crossing_table(const CaptureSet& set, const std::vector<CrossingFigures>& crossings) {
  HtmlTable table{
      .caption =
          "Differences of the two lines before and after, measured by matches held out of the "
          "estimate; pixels at a width of 4096. Sigma is the estimate's own "
          "standard deviation.",
      .header = {"crossing", "matches", "mm before", "after", "sigma", "deg before", "after",
                 "sigma", "px before", "after", "sigma", "median px before", "after",
                 "trustworthy"}};
  for (const CrossingFigures& figures : crossings) {
    const Disagreement &before = figures.before, &after = figures.after;
    table.rows.push_back({{crossing_name(set, figures.along_x, figures.along_z)},
                          {std::to_string(figures.matches + figures.held_out_matches)},
                          {fixed_number(before.position_mm, 2)},
                          {fixed_number(after.position_mm, 2)},
                          {fixed_number(figures.sigma_mm, 2)},
                          {fixed_number(before.rotation_deg, 3)},
                          {fixed_number(after.rotation_deg, 3)},
                          {fixed_number(figures.sigma_deg, 3)},
                          {fixed_number(before.rotation_px, 2)},
                          {fixed_number(after.rotation_px, 2)},
                          {fixed_number(figures.sigma_px, 2)},
                          {fixed_number(before.median_px, 2)},
                          {fixed_number(after.median_px, 2)},
                          {figures.trustworthy ? "yes" : "no", !figures.trustworthy}});
  }
  return table;
}

}  // namespace raywalk::calibrate
