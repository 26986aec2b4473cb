#include "calibrate/grid/grid_page.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "calibrate/grid/grid_drawing.h"
#include "calibrate/grid/grid_estimation.h"
#include "calibrate/grid/test_grid.h"
#include "core/report/markup_check.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Estimated {
  TestGrid grid;
  GridResult result;

  explicit Estimated(const TestGridSettings& settings) : grid(TestGridMaker(settings, 3).make()) {
    grid.set.source = "hall & {garden}";
    result = estimate_from_matches(grid.set, GridMethod::kPoses, grid.solved,
                                   nominal_poses(grid.set), grid.crossings);
  }
  std::string page() const {
    return grid_page(grid_document(grid.set, result), grid_drawing(grid.set, result));
  }
};

TEST(GridPageTest, ShowsCrossingsLinesModelsAndDeviations) {
  Estimated estimated({.stations = 11, .matches = 20});
  GridResult& result = estimated.result;
  result.crossings[1].before.rotation_px = 123.456;
  result.crossings[2].after.position_mm = 7.891;
  result.crossings[0].correction_mm = 17.654;
  result.lines[1].height_mm = {3.21, 0.05};
  result.lines[1].position_models = {{.name = "straight"}, {.name = "bowed", .kept = true}};
  result.lines[1].rotation_models = {{.name = "twisted", .bic = -77.71, .kept = true}};
  result.warnings.clear();
  result.notes = {"a <note>"};
  const std::string page = estimated.page();
  EXPECT_EQ(markup_fault(page), "");
  EXPECT_THAT(page, AllOf(HasSubstr("Grid of hall &amp; {garden}"),
                          HasSubstr("4 lines, 44 stations, from solved poses"),
                          HasSubstr("→ 7.89 mm"), HasSubstr("123.46 →"), HasSubstr("x0 × z1"),
                          HasSubstr("17.65"), HasSubstr("a &lt;note&gt;")));
  EXPECT_THAT(page, AllOf(HasSubstr("3.21 ± 0.05"), HasSubstr("<td>bowed</td>"), HasSubstr("-77.7"),
                          HasSubstr("common error of solved lines"), HasSubstr("Line z1: position"),
                          HasSubstr("Line x0: attitude"), HasSubstr("class=\"raywalk-plan"),
                          Not(HasSubstr("<h2>Warnings</h2>"))));
}

TEST(GridPageTest, SaysWhatAGridWithoutCrossingsLacks) {
  Estimated estimated({.lines_x = 1, .lines_z = 0, .stations = 11});
  estimated.result.method = GridMethod::kRotation;
  estimated.result.warnings = {"look & see"};
  estimated.result.notes.clear();
  const std::string page = estimated.page();
  EXPECT_EQ(markup_fault(page), "");
  EXPECT_THAT(page,
              AllOf(HasSubstr("1 line, 11 stations, from matches at the crossings alone"),
                    HasSubstr("<h2>Warnings</h2>"), HasSubstr("look &amp; see"),
                    Not(HasSubstr("<h2>At the crossings</h2>")), Not(HasSubstr("largest rotation")),
                    Not(HasSubstr("common error of solved lines")),
                    Not(HasSubstr("Models of the rails")), Not(HasSubstr("<h2>Notes</h2>"))));
}

// What is small against the rest of a line is nothing that its rail has.
TEST(GridPageTest, DeviationsAreThoseOfTheStations) {
  Estimated estimated({.stations = 11, .jitter_mm = 0.01, .jitter_deg = 0.001, .matches = 20});
  FramePose& moved = *estimated.result.poses[4];
  moved.position_m.y() += 0.02;
  moved.world_from_camera =
      matrix_of({0.0, radians_from_degrees(1.0), 0.0}) * moved.world_from_camera;
  const auto document = grid_document(estimated.grid.set, estimated.result);
  const auto& line = document["deviations"][0];
  EXPECT_EQ(line["line"], "x0");
  ASSERT_EQ(line["stations"].size(), 11U);
  for (int i = 0; i < 11; ++i) {
    const auto& station = line["stations"][static_cast<size_t>(i)];
    EXPECT_EQ(station["name"], estimated.grid.set.frames[static_cast<size_t>(i)].name);
    EXPECT_NEAR(station["up_mm"], i == 4 ? 20.0 : 0.0, 0.5) << i;
    EXPECT_NEAR(station["along_mm"], 0.0, 0.5) << i;
    EXPECT_NEAR(station["about_y_deg"], i == 4 ? 1.0 : 0.0, 0.05) << i;
    EXPECT_NEAR(station["about_x_deg"], 0.0, 0.05) << i;
  }
}

}  // namespace
}  // namespace raywalk::calibrate
