#include "core/room/distance_volume.h"

#include <gmock/gmock.h>

#include "core/base/error.h"

namespace raywalk {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

constexpr PanoramaSize kLeftOutSize{8, 4};

TEST(LeftOutPixels, AreFoundByStationAndColumn) {
  const std::vector<std::int32_t> runs = {2, 7, 3, 4, 1, 3, 2, 4, 1, 3, 0, 1, 1, 0, 0, 4};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_FALSE(pixels.any(0));
  EXPECT_TRUE(pixels.any(1));
  EXPECT_FALSE(pixels.any(3));
  EXPECT_THAT(pixels.rows(1, 0), ElementsAre(RowRun{0, 4}));
  EXPECT_THAT(pixels.rows(1, 1), IsEmpty());
  EXPECT_THAT(pixels.rows(1, 3), ElementsAre(RowRun{0, 1}, RowRun{2, 4}));
  EXPECT_THAT(pixels.rows(2, 7), ElementsAre(RowRun{3, 4}));
  EXPECT_THAT(pixels.rows(0, 7), IsEmpty());
}

TEST(LeftOutPixels, FollowASubsetOfTheStations) {
  const std::vector<std::int32_t> runs = {1, 0, 0, 4, 3, 5, 1, 2};
  const std::vector<int> kept = {0, 2, 3};
  const LeftOutPixels pixels = LeftOutPixels(runs, kLeftOutSize, 4, "a.h5").subset(kept);
  EXPECT_FALSE(pixels.any(0));
  EXPECT_FALSE(pixels.any(1));
  EXPECT_THAT(pixels.rows(2, 5), ElementsAre(RowRun{1, 2}));
}

TEST(LeftOutPixels, AreStoredForPanoramasOfAnotherSize) {
  const std::vector<std::int32_t> runs = {1, 3, 1, 3};
  const LeftOutPixels pixels(runs, kLeftOutSize, 4, "a.h5");
  EXPECT_EQ(pixels.stored_runs(kLeftOutSize), runs);
  EXPECT_THAT(pixels.stored_runs({4, 2}), ElementsAre(1, 1, 0, 2));
  EXPECT_THAT(pixels.stored_runs({16, 8}), ElementsAre(1, 6, 2, 6, 1, 7, 2, 6));
}

TEST(LeftOutPixels, RunsOutsideThePanoramaOrTheLineAreRefused) {
  const auto with = [](std::vector<std::int32_t> runs) {
    return [runs] { LeftOutPixels(runs, kLeftOutSize, 4, "a.h5"); };
  };
  const auto refused = ThrowsMessage<Error>(HasSubstr("a.h5: 'left_out'"));
  for (const std::vector<std::int32_t>& runs : std::vector<std::vector<std::int32_t>>{
           {4, 0, 0, 1}, {-1, 0, 0, 1}, {0, 8, 0, 1}, {0, 0, 2, 2}, {0, 0, 0, 5}, {0, 0, 0}}) {
    EXPECT_THAT(with(runs), refused);
  }
}

}  // namespace
}  // namespace raywalk
