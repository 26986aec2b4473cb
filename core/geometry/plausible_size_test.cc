#include "core/geometry/plausible_size.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A square of side 10 spacings and, if `closed`, its cell; positions times `unit`.
Grid square(double unit, bool closed = true) {
  std::vector<StationPose> stations;
  const auto add = [&](int x, int z) {
    stations.push_back(
        {fmt::format("{}.jpg", stations.size()), {0.1 * unit * x, 0.0, 0.1 * unit * z}, ""});
  };
  for (int i = 0; i <= 10; ++i) add(i, 0);
  for (int i = 0; i <= 10; ++i) add(i, 10);
  for (int i = 0; closed && i <= 10; ++i) add(0, i);
  for (int i = 0; closed && i <= 10; ++i) add(10, i);
  return find_grid(stations, {});
}

TEST(DoubtOfUnit, MetresAreNotDoubted) {
  EXPECT_FALSE(doubt_of_unit(square(1.0)).has_value());
  EXPECT_FALSE(doubt_of_unit(square(15.0)).has_value()) << "a hall";
}

TEST(DoubtOfUnit, MillimetresAreDoubtedWithTheirSizes) {
  const auto doubt = doubt_of_unit(square(1000.0));
  ASSERT_TRUE(doubt.has_value());
  EXPECT_THAT(*doubt, AllOf(HasSubstr("100 m apart"), HasSubstr("1000 m wide"),
                            HasSubstr("divide millimetres by 1000")));
}

TEST(DoubtOfUnit, CentimetresAndLinesWithoutCellsAreDoubtedToo) {
  EXPECT_TRUE(doubt_of_unit(square(100.0)).has_value());
  EXPECT_TRUE(doubt_of_unit(square(1000.0, false)).has_value());
}

TEST(DoubtOfUnit, DenseStationsInMillimetresAreDoubtedByTheirCell) {
  std::vector<StationPose> stations;
  const auto add = [&](double x, double z) {
    stations.push_back({fmt::format("{}.jpg", stations.size()), {x, 0.0, z}, ""});
  };
  for (int i = 0; i <= 100; ++i) {
    for (const double place : {0.0, 100.0}) {
      add(i, place);
      add(place, i);
    }
  }
  EXPECT_TRUE(doubt_of_unit(find_grid(stations, {})).has_value());
}

}  // namespace
}  // namespace raywalk
