#include "calibrate/grid/grid_warnings.h"

#include <gmock/gmock.h>

#include "calibrate/grid/test_grid.h"

namespace raywalk::calibrate {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A grid of 2 x 2 lines, 1 m apart, whose first line was found `across_mm` off its place.
GridResult found_across(double across_mm) {
  const TestGrid grid = TestGridMaker({}, 1).make();
  GridResult result;
  for (size_t i = 0; i < grid.set.lines.size(); ++i) {
    LineFit line{.line = static_cast<int>(i), .id = grid.set.lines[i].id};
    line.connected = true;
    result.lines.push_back(line);
  }
  result.lines[0].across_mm.value = across_mm;
  add_warnings(grid.set, {.spacing_m = 0.0375}, &result);
  return result;
}

TEST(GridWarningsTest, ARailAtThePlaceOfAnotherLineIsReported) {
  for (const double across_mm : {510.0, 990.0, 1400.0}) {
    const GridResult result = found_across(across_mm);
    EXPECT_FALSE(result.trustworthy);
    EXPECT_THAT(result.warnings, ElementsAre(AllOf(HasSubstr("line x0: found"),
                                                   HasSubstr("nearer to the place of line x1"))));
  }
}

TEST(GridWarningsTest, AUsualErrorOfPlacingIsNotReported) {
  for (const double across_mm : {-600.0, -30.0, 0.0, 80.0, 490.0}) {
    EXPECT_THAT(found_across(across_mm).warnings, IsEmpty()) << across_mm;
  }
}

}  // namespace
}  // namespace raywalk::calibrate
