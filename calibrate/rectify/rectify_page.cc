#include "calibrate/rectify/rectify_page.h"

#include "calibrate/grid/grid_sections.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

void add_head(JsonPage page) {
  page.facts({{"frames", "{grid_frames}"},
              {"validation frames", "{validation_frames}"},
              {"left out", "{left_out:size}"},
              {"frames with a mask of their own", "{frame_masks.frames}", "frame_masks"},
              {"of their sphere is masked", "{frame_masks.masked_share:.2%}", "frame_masks"}});
  page.paragraph(
          "Frames are rotated to world axes in one resampling; their positions are those of the "
          "estimated poses. The next step:")
      .paragraph("{pack_command}")
      .paragraph(
          "What the calibration gains: pack {before_list} too, the frames at their planned "
          "positions, and give its room to raywalk-render validate --before.")
      .when("left_out")
      .paragraph("Omitted, without a pose: {left_out:joined}.");
}

// Of the part "exposure".
void add_evidence(JsonPage page) {
  page.paragraph(
          "How it was measured: {patches} small surfaces, each seen by two of {links} pairs of "
          "frames, in {scene_parts} of {scene_parts_in_all} parts of the scene. Each is compared "
          "at its own distance, found by matching both ways, so that parallax does not enter; "
          "darkening towards the edges of the lenses is fitted as common to all frames. The "
          "standard errors come from the scatter between the parts of the scene, and from what "
          "halves of the surfaces disagree by beyond it. The pairs close {loops:counted loop}, to "
          "{loop_error:.2%}. A difference counts if it would occur by chance in less than "
          "{significance:.2g%} of captures.")
      .table("kinds",
             {{"light", "{kind}"}, {"taken", "{model_text}"}, {"differs by", "{spread:.2%}"}},
             "What is taken, and by how much frames differ (RMS)")
      .table("kinds.tests",
             {{"light", "{^kind}"},
              {"assumed", "{model_text}"},
              {"largest deviation / standard errors", "{largest_t:.1f}"},
              {"at", "{frame}"},
              {"allowed by chance", "{^t_limit:.1f}"},
              {"verdict", "{rejected:contradicted|agrees}"}},
             "Which differences the measurement shows")
      .table("kinds.halves",
             {{"light", "{^kind}"},
              {"halves by", "{split}"},
              {"disagree by", "{difference:.2%}"},
              {"expected by chance", "{by_chance:.2%}"}},
             "Halves of the surfaces, measured separately (RMS over the frames)")
      .table("/frames",
             {{"frame", "{name}"},
              {"measured", "{exposure.brightness.measured_change:.2%}"},
              {"taken", "{exposure.brightness.fitted_change:.2%}"},
              {"standard error", "{exposure.brightness.error:.2%}"},
              {"significant", "{exposure.brightness.corrected}"},
              {"gain red", "{gain.red:.5g}"},
              {"green", "{gain.green:.5g}"},
              {"blue", "{gain.blue:.5g}"}},
             "Brightness of every frame, relative to the mean of all");
}

void add_exposure(JsonPage page) {
  page.section("Exposure");
  page.when("!exposure").paragraph("Not compared (--no-gain): the frames' light is as captured.");
  JsonPage exposure = page.within("exposure").paragraph("The result: {summary}.");
  const LinePlot axes{.title = "Gain of every frame",
                      .x_label = "position on the rail / m",
                      .y_label = "mean gain / stops"};
  JsonPage corrected = exposure.when("corrected_frames");
  corrected.figures({corrected.plot(axes, {{"/frames", "{line:|}", "rail_m", "gain_stops"}},
                                    "Mean over the colours; 0 stops: not corrected")});
  add_evidence(exposure.when("kinds.0.tests"));
}

}  // namespace

void add_overlays(std::string_view list, const fs::path& out, const JsonPage& page) {
  page.when(list)
      .section("Overlays of the lines")
      .paragraph(
          "The two panoramas nearest to each crossing, one in red, the other in cyan, in the "
          "direction with the most texture: where they agree the picture is grey. They were not "
          "taken at exactly the same position, so near objects keep a little parallax.");
  for (JsonPage& crossing : page.parts(list)) {
    const auto figure = [&](std::string_view file, std::string_view differ) {
      const std::string caption =
          crossing.text("{along_x} × {along_z}, frames {frame_x} and {frame_z}, ") +
          crossing.text(differ);
      return picture_figure(read_picture(out / crossing.text(file)), EmbeddedFormat::kJpeg, caption,
                            caption);
    };
    crossing.figures({figure("{before}", "before: differ by {difference_before:.2f} levels RMS"),
                      figure("{after}", "after: differ by {difference_after:.2f} levels RMS")});
  }
}

std::string rectify_page(const nlohmann::ordered_json& document, const fs::path& out) {
  JsonPage page(document, "Rectified frames", "{source}");
  add_head(page);
  add_crossings("grid_crossings", page);
  add_overlays("crossings", out, page);
  add_exposure(page);
  return page.html();
}

}  // namespace raywalk::calibrate
