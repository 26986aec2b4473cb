#include "calibrate/chain/calibration_page.h"

#include "calibrate/grid/grid_sections.h"
#include "calibrate/rectify/rectify_page.h"

namespace raywalk::calibrate {
namespace {

void add_trade(JsonPage page) {
  page.section("Accuracy and time of fewer keyframes")
      .table("keyframe_trade",
             {{"keyframes every", "{keyframes_mm:g mm}"},
              {"keyframes", "{keyframes}"},
              {"time / s", "{seconds:.0f}"},
              {"median / mm", "{median_mm:.3f}"},
              {"largest / mm", "{largest_mm:.3f}"},
              {"median / deg", "{median_deg:.4f}"},
              {"largest / deg", "{largest_deg:.4f}"},
              {"trustworthy", "{trustworthy}", "!trustworthy"}},
             "Differences from the densest spacing, over all stations; those without a solved pose "
             "are predicted from their rail. 0 mm: every station is a keyframe.");
}

void add_steps(JsonPage page) {
  page.section("The steps")
      .table("steps", {{"step", "{step}", "", "{page:|}"},
                       {"what it gives", "{purpose}"},
                       {"time / s", "{seconds:.1f}"},
                       {"done earlier", "{reused}"}});
}

}  // namespace

std::string calibration_page(const nlohmann::ordered_json& document,
                             const std::filesystem::path& out) {
  JsonPage page(document, "Calibration of {source}",
                "{stations:counted station} on {lines:counted line}, {method is poses:poses from "
                "COLMAP and the slider|lines aligned at their crossings without solved poses}");
  add_verdict(page);
  add_crossings("crossings", page);
  add_lines(page);
  add_overlays("overlays", out, page);
  add_trade(page.when("keyframe_trade"));
  add_steps(page);
  page.section("The next step").paragraph("{pack_command}");
  return page.html();
}

}  // namespace raywalk::calibrate
