#include "calibrate/grid/grid_sections.h"

namespace raywalk::calibrate {

void add_verdict(JsonPage page) {
  page.facts({{"trustworthy", "{trustworthy}"},
              {"lines", "{lines:size}"},
              {"crossings", "{crossings:size}"},
              {"largest rotation at a crossing, W = 4096",
               "{largest_disagreement.before.rotation_px:.2f} → "
               "{largest_disagreement.after.rotation_px:.2f px}",
               "largest_disagreement"},
              {"largest displacement at a crossing",
               "{largest_disagreement.before.position_mm:.2f} → "
               "{largest_disagreement.after.position_mm:.2f mm}",
               "largest_disagreement"}});
  page.warnings("warnings");
  page.when("notes").section("Notes").paragraphs("notes");
}

void add_crossings(std::string_view list, const JsonPage& page) {
  const JsonColumn crossing{"crossing", "{along_x} × {along_z}", "!trustworthy"};
  page.when(list)
      .section("At the crossings")
      .paragraph(
          "Displacement and rotation of the two lines' panoramas relative to each other, before "
          "and after, measured by matches held out of the estimate, ± one standard deviation by "
          "the matches' scatter. A remaining difference is significant only where it exceeds them. "
          "σ: standard deviation by the estimate itself. Pixels are those of a panorama 4096 wide. "
          "Epipolar: the median distance of a match from its epipolar line.")
      .table(list,
             {crossing,
              {"matches used", "{matches}"},
              {"held out", "{held_out_matches}"},
              {"before, mm", "{before.position_mm:.2f} ± {before.position_sigma_mm:.2f}"},
              {"after, mm", "{after.position_mm:.2f} ± {after.position_sigma_mm:.2f}"},
              {"σ, mm", "{sigma_mm:.2f}"},
              {"trustworthy", "{trustworthy}", "!trustworthy"}},
             "Displacement")
      .table(list,
             {crossing,
              {"before, °", "{before.rotation_deg:.3f} ± {before.rotation_sigma_deg:.3f}"},
              {"after, °", "{after.rotation_deg:.3f} ± {after.rotation_sigma_deg:.3f}"},
              {"σ, °", "{sigma_deg:.4f}"},
              {"px", "{before.rotation_px:.2f} → {after.rotation_px:.2f}"},
              {"σ, px", "{sigma_px:.2f}"},
              {"epipolar, px", "{before.median_px:.2f} → {after.median_px:.2f}"}},
             "Rotation");
}

void add_lines(JsonPage page) {
  const JsonColumn line{"line", "{id}", "!connected"};
  page.section("Lines")
      .paragraph(
          "Every line relative to the plan, ± one standard deviation: its middle along and across "
          "the rail and in height, the direction of the rail, the attitude of the camera, and the "
          "stations' scatter about the rail (standard deviation per component). The common motion "
          "of all lines is unobservable; it is chosen so that the positions fit the plan best. "
          "Emphasised: lines that no matches connect to others.")
      .table("lines",
             {line,
              {"stations solved", "{solved_stations} of {stations}"},
              {"along, mm", "{along_mm.value:.2f} ± {along_mm.sigma:.2f}"},
              {"across, mm", "{across_mm.value:.2f} ± {across_mm.sigma:.2f}"},
              {"height, mm", "{height_mm.value:.2f} ± {height_mm.sigma:.2f}"},
              {"scatter along, mm", "{jitter_along_mm:.2f}"},
              {"across, mm", "{jitter_mm:.2f}"},
              {"model", "{position_model}"}},
             "Positions")
      .table("lines",
             {line,
              {"heading, °", "{heading_deg.value:.3f} ± {heading_deg.sigma:.3f}"},
              {"tilt, °", "{tilt_deg.value:.3f} ± {tilt_deg.sigma:.3f}"},
              {"yaw, °", "{yaw_deg.value:.3f} ± {yaw_deg.sigma:.3f}"},
              {"pitch, °", "{pitch_deg.value:.3f} ± {pitch_deg.sigma:.3f}"},
              {"roll, °", "{roll_deg.value:.3f} ± {roll_deg.sigma:.3f}"},
              {"scatter, °", "{jitter_deg:.3f}"},
              {"model", "{rotation_model}"}},
             "Directions and attitudes");
}

}  // namespace raywalk::calibrate
