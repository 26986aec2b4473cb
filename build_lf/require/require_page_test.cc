#include "build_lf/require/require_page.h"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "build_lf/require/require_document.h"
#include "build_lf/require/test_distances.h"
#include "core/report/markup_check.h"
#include "core/room/connection_errors.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class RequirePageTest : public RequireTest {
 protected:
  std::string page(const RoomRequirements& shown) const {
    return require_page(require_document(room_, shown), figures_);
  }

  RoomRequirements requirements_{
      .distances = "given",
      .tolerance_px = 0.5,
      .distance = {.near_m = 0.5,
                   .median_m = 2.5,
                   .far_m = 8.25,
                   .sky_share = 0.125,
                   .known_share = 0.875,
                   .omega_error_per_m = 0.00321},
      .layers = {.omega_min_per_m = 0.121,
                 .omega_max_per_m = 2.0,
                 .by_d_p = {{.d_p_m = 0.75, .layers = 5},
                            {.d_p_m = 1.0, .layers = 13},
                            {.d_p_m = 1.25, .layers = 25}}},
      .spacing = {.captured_median_m = 0.0625,
                  .captured_max_m = 0.0725,
                  .needed_without_depth_m = 0.0071,
                  .needed_with_layers = {{.layers = 1, .needed_m = 0.0242},
                                         {.layers = 4, .needed_m = 0.0979}},
                  .needed_by_error_m = 0.0616,
                  .measured_up_to_m = 0.0787,
                  .needed_with_distances_m = 0.0939,
                  .stations = 244,
                  .stations_needed_with_distances = 32,
                  .held_out = {{.stride = 3,
                                .step_m = 0.0512,
                                .views = 24,
                                .psnr_with_distances_db = 38.5,
                                .psnr_without_depth_db = 21.5,
                                .psnr_of_tolerance_db = 35.5,
                                .hidden_share = 0.012}}},
      .connection = {.model_k_deg = 72.0},
      .storage = {.reach_m = 1.0,
                  .panorama_width_px = 32,
                  .worth_width_px = 2000.25,
                  .distance_width_px = 512,
                  .needed_distance_width_px = 256,
                  .share_within_tolerance = 0.998,
                  .omega_steps = 200,
                  .omega_bits = 8,
                  .ray_bytes = 8'000'000,
                  .ray_bytes_thinned = 4'000'000,
                  .ray_bytes_worth = 1'000'000,
                  .distance_bytes = 600'000,
                  .distance_bytes_needed = 400'000}};
  Room room_ = room_of({.width = 32});
  RequirementFigures figures_{.directions = svg_figure("<svg/>", "directions"),
                              .around = {svg_figure("<svg/>", "around")},
                              .layers = svg_figure("<svg/>", "layers over d_p"),
                              .ghosts = svg_figure("<svg/>", "ghosts"),
                              .connection = {svg_figure("<svg/>", "E_t")}};
};

TEST_F(RequirePageTest, ShowsAllThatWasMeasured) {
  const std::string html = page(requirements_);
  EXPECT_EQ(markup_fault(html), "");
  for (const char* shown : {"32 x 16 px, for a tolerance of 0.5 px",
                            "0.50 m to 8.25 m",
                            "<dd>given</dd>",
                            "<dd>13</dd>",
                            "7.1 mm",
                            "9.4 cm",
                            "6.2 cm",
                            "32 of 244",
                            "<dd>90 degrees</dd>",
                            "2000 px",
                            "covers 12.5 % of the directions; 87.5 % of them are known",
                            "0.00321 per metre: 2.0 cm",
                            "from 0.121 to 2.000 per metre",
                            "0.750 m",
                            "0.5 px, 5.625 degrees",
                            "38.5 dB",
                            "1.2 %",
                            "not dense enough",
                            "not measured on this room",
                            "99.8 % of the directions within the tolerance",
                            "200 steps of inverse distance, 8 bits",
                            "8.0 MB",
                            "50.0 %",
                            "12.5 %",
                            "distances, 256 px wide",
                            "66.7 %",
                            "the scene",
                            "ghosts",
                            "E_t"}) {
    EXPECT_THAT(html, HasSubstr(shown));
  }
  EXPECT_THAT(html, HasSubstr("raywalk-render connect-error " + path_.string()));
  EXPECT_THAT(html, HasSubstr("displaced by the tolerance")) << "the plot of stations left out";
  EXPECT_THAT(html, Not(HasSubstr("thinned")));
}

TEST_F(RequirePageTest, EmphasisesTheSpacingsThatTheCaptureKeeps) {
  const std::string html = page(requirements_);
  EXPECT_THAT(html, AllOf(HasSubstr("<td>2.4 cm</td>"), HasSubstr("\"best\">9.8 cm</td>"),
                          HasSubstr("<td>6.2 cm</td>"), HasSubstr("\"best\">7.9 cm</td>")));
  EXPECT_THAT(html, HasSubstr("\"best\">38.5 dB</td>"));
  requirements_.spacing.held_out[0].psnr_of_tolerance_db = 38.75;
  EXPECT_THAT(page(requirements_), HasSubstr("<td>38.5 dB</td>"));
}

TEST_F(RequirePageTest, ShowsTheMeasuredConnectionAndTheThinnedRoom) {
  store_connection_errors(path_, {.generation = "hlf-vd",
                                  .viewpoints = 5,
                                  .overlap_deg = 5.0,
                                  .common_share = 0.9,
                                  .rows = {{60.0, 2.0, 2.0, 1.0}, {80.0, 3.0, 3.0, 1.0}}});
  requirements_.connection.measured = {{.generation = "hlf-vd", .k_deg = 60.0, .e_connect = 2.0}};
  requirements_.thinned = {.room = "<thin> & co.lf",
                           .stations = 33,
                           .distance_maps = 7,
                           .bytes = 1'200'000,
                           .views = 49,
                           .psnr_db = 37.5,
                           .worst_psnr_db = 30.25};
  const std::string html = page(requirements_);
  EXPECT_EQ(markup_fault(html), "");
  for (const char* shown : {"60 degrees for hlf-vd views: measured E_connect", "measured, hlf-vd",
                            ">2.00</td>", "&lt;thin&gt; &amp; co.lf", "<dd>33</dd>", "<dd>7</dd>",
                            "1.2 MB", "<dd>49</dd>", "37.5 dB", "30.2 dB"}) {
    EXPECT_THAT(html, HasSubstr(shown));
  }
  EXPECT_THAT(html, Not(HasSubstr("connect-error")));
}

TEST_F(RequirePageTest, SaysWhereThereIsNothingToShow) {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  room_ = room_of({.cells_z = 0, .width = 32});
  figures_.connection.clear();
  requirements_.connection.model_k_deg.reset();
  requirements_.distance = {.near_m = kAny, .median_m = kAny, .far_m = kAny, .sky_share = 1.0};
  requirements_.spacing.needed_without_depth_m = kAny;
  requirements_.spacing.held_out.clear();
  requirements_.storage.worth_width_px = kAny;
  const std::string html = page(requirements_);
  EXPECT_EQ(markup_fault(html), "");
  for (const char* shown :
       {"sky to sky", "nearer than sky", "no cell", "no lines connect", "\"best\">any</td>",
        "any distance apart, and the capture is dense enough", "panorama of any width"}) {
    EXPECT_THAT(html, HasSubstr(shown));
  }
  EXPECT_THAT(html, Not(HasSubstr("Where two maps see")));
  EXPECT_THAT(html, Not(HasSubstr("re-created from its two neighbours")));
}

}  // namespace
}  // namespace raywalk::build_lf
