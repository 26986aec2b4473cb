#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/view/column_renderer.h"
#include "core/view/source_visibility.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

// A pillar between the front line and the wall; the viewpoint is on the line, in the middle.
SyntheticRoomSpec room_with_pillar() {
  SyntheticRoomSpec spec = box_room(128);
  spec.spacing_m = 0.25;
  spec.scene.obstacle = SceneBox{{-0.15, -0.6, 0.8}, {0.15, 0.6, 0.9}};
  return spec;
}

// What the renderer remembers of one station must not stand for another.
TEST(SourceVisibility, IsThatOfTheStationReadWhereOnlyOneIs) {
  const TestRoom room(room_with_pillar());
  const Line& front = room.room().grid().lines[1];
  const auto stations = static_cast<int>(front.stations.size());
  const Eigen::Vector3d at_m = front.stations[static_cast<size_t>(stations / 2)].position_m;
  const int before = stations / 2 - 2;
  const RaySource between{.line = 1, .station = before, .fraction = 0.5};
  const ViewPlan plan(room.room().grid(), at_m, between);
  const std::vector<int> lines{1};
  const std::vector<MapStation> maps = nearest_maps(room.room(), lines, at_m, 0.0, stations, 2);
  DistanceView distances(room.room());
  distances.compute(maps, at_m);
  const ViewInputs view{.room = room.room(),
                        .plan = plan,
                        .output = room.room().panorama(),
                        .rows = {0, room.room().panorama().height},
                        .distances = &distances,
                        .layers = std::nullopt,
                        .fill_maps = maps,
                        .stations_mixed = 1};
  const auto column = [&](ColumnRenderer& renderer, int u, const RaySource& source) {
    std::vector<std::uint8_t> rgb(3 * static_cast<size_t>(view.output.height) + 1);
    renderer.render(u, {&source, 1}, rgb.data());
    rgb.pop_back();
    return rgb;
  };
  const auto filled = [&](ColumnRenderer& renderer) { return renderer.counts().filled; };
  const ColumnPlan sources = plan.column(0.0);
  std::int64_t only_left = 0, only_right = 0;
  for (int u = 0; u < view.output.width; ++u) {
    ColumnRenderer left(view), right(view), both(view);
    column(left, u, sources.front[0]);
    const auto right_alone = column(right, u, sources.front[1]);
    column(both, u, sources.front[0]);
    EXPECT_EQ(column(both, u, sources.front[1]), right_alone) << "column " << u;
    EXPECT_EQ(filled(both), filled(left) + filled(right)) << "column " << u;
    only_left += std::max<std::int64_t>(0, filled(right) - filled(left));
    only_right += std::max<std::int64_t>(0, filled(left) - filled(right));
  }
  EXPECT_GT(only_left, 0) << "the pillar hides something from one of them only";
  EXPECT_GT(only_right, 0);
}

}  // namespace
}  // namespace raywalk
