#include "capture/plan/line_selection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/plan/test_plan.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using testing::ElementsAre;

std::vector<std::string> ids_of(const CapturePlan& plan) {
  std::vector<std::string> ids;
  for (const CaptureLine& line : plan.lines) ids.push_back(line.id);
  return ids;
}

TEST(SelectLines, TakesIdsAndRangesInTheOrderOfThePlan) {
  CaptureConfig config = one_cell_config();
  config.grid.cells_z = 3;
  config.slider.high_limit_mm = 4000.0;
  const CapturePlan plan = plan_capture(config);  // x0 to x3, z0, z1
  const auto selected = [&](const std::vector<std::string>& words) {
    return select_lines(plan, config.camera, words);
  };
  EXPECT_THAT(ids_of(selected({"z1", "x1-x3"})), ElementsAre("x1", "x2", "x3", "z1"));
  EXPECT_THAT(ids_of(selected({"x3-z0"})), ElementsAre("x3", "z0"));
  for (const char* wrong : {"x4", "x3-x1", "x1-", "-", ""}) {
    EXPECT_THROW(selected({wrong}), UsageError) << wrong;
  }
  EXPECT_FALSE(selected({}).part_of);
  EXPECT_FALSE(selected({"x0-z1"}).part_of);
  EXPECT_EQ(plan_json(selected({"x0-z1"}), config.camera), plan_json(plan, config.camera));
}

TEST(SelectLines, APartNamesItsWholeWhateverTheRail) {
  CaptureConfig config = one_cell_config();
  const auto part_of = [&] {
    const CapturePlan part = select_lines(plan_capture(config), config.camera, {"x1"});
    return nlohmann::json::parse(plan_json(part, config.camera))["part_of"];
  };
  const nlohmann::json first = part_of();
  EXPECT_EQ(first["lines"], nlohmann::json({"x0", "x1", "z0", "z1"}));
  config.slider.first_station_mm = 30.0;
  EXPECT_EQ(part_of(), first);
  config.grid.overhang_mm = 0.0;
  EXPECT_NE(part_of(), first);
}

}  // namespace
}  // namespace raywalk::capture
