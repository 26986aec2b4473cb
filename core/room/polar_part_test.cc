// Rows near the poles: which columns they are read from, and where these are stored.
#include "core/room/polar_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

// Distance between neighbouring columns at a row's lower edge, in row heights: the largest distance
// that a sample between this row and the next one meets.
double column_distance(int row, PanoramaSize size) {
  const double from_pole = (std::min(row, size.height - 2 - row) + 1.0) / size.height * kPi;
  return std::sin(from_pole) * (kTwoPi / size.width) / (kPi / size.height);
}

TEST(PolarColumns, AreAsFarApartAsHalfARowsHeightAllows) {
  for (const int width : {16, 64, 512, 4096, 6000, 8192, 32768}) {
    const PanoramaSize size{width, width / 2};
    const PolarColumns polar = polar_columns(size);
    for (int row = 0; row + 1 < size.height; ++row) {
      const int step = 1 << polar_doublings(polar, row, size.height);
      const bool could_be_wider = step < 16 && width % (2 * step) == 0;
      if (could_be_wider) {
        ASSERT_GT(2 * step * column_distance(row, size), 0.5 - 1e-9) << width << " row " << row;
      }
      if (step == 1) continue;
      ASSERT_LE(step * column_distance(row, size), 0.5 + 1e-9) << width << " row " << row;
      ASSERT_EQ(width % step, 0);
    }
    const int middle = polar_doublings(polar, size.height / 2 - 1, size.height);
    EXPECT_EQ(middle, 0);
    if (width >= 4096 && width % 16 == 0) {
      EXPECT_EQ(1 << polar_doublings(polar, 0, size.height), 16);
    }
  }
}

TEST(PolarColumns, AreNeighboursWhereTheWidthCannotBeHalved) {
  const PolarColumns polar = polar_columns({4100, 2050});
  EXPECT_EQ(1 << polar_doublings(polar, 0, 2050), 4);
  const PolarColumns odd = polar_columns({1025, 512});
  EXPECT_EQ(polar_doublings(odd, 0, 512), 0);
}

// A station's rays with a polar part; every byte tells its place.
class StoredStation {
 public:
  explicit StoredStation(PanoramaSize size)
      : size_(size), part_(size), rays_(3 * pixels(size.width + part_.columns())) {
    const std::size_t columns = 3 * pixels(size.width);
    for (std::size_t i = 0; i < columns; ++i) rays_[i] = byte_at(i);
    part_.fill(std::span(rays_).first(columns), std::span(rays_).subspan(columns));
  }

  const PolarPart& part() const { return part_; }
  // Whether `offset` holds the six bytes of two pixels of a column, from row `upper` on.
  bool holds(std::int32_t offset, int column, int upper) const {
    const std::size_t plain =
        3 * (static_cast<std::size_t>(column) * static_cast<std::size_t>(size_.height) +
             static_cast<std::size_t>(upper));
    const auto at = rays_.begin() + offset;
    return std::equal(at, at + 6, rays_.begin() + static_cast<std::ptrdiff_t>(plain));
  }
  std::size_t bytes() const { return rays_.size(); }

 private:
  std::size_t pixels(int columns) const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(size_.height);
  }
  // Any two places less than a few thousand million bytes apart differ somewhere in six bytes.
  static std::uint8_t byte_at(std::size_t i) {
    return static_cast<std::uint8_t>((i * 2654435761U) >> 13);
  }

  PanoramaSize size_;
  PolarPart part_;
  std::vector<std::uint8_t> rays_;
};

TEST(PolarPart, HoldsWhatEverySampleReads) {
  for (const PanoramaSize size :
       {PanoramaSize{512, 256}, PanoramaSize{1024, 512}, PanoramaSize{600, 300},
        PanoramaSize{64, 32}, PanoramaSize{4096, 2048}}) {
    const StoredStation station(size);
    const RayLayout& layout = station.part().layout();
    std::set<int> levels;
    for (int upper = 0; upper + 1 < size.height; ++upper) {
      const int doublings = polar_doublings(layout.polar, upper, size.height);
      levels.insert(doublings);
      for (int u = 0; u < size.width; u += 1 << doublings) {
        const std::int32_t offset = ray_offset(layout, doublings, u, upper, size.height);
        ASSERT_GE(offset, 0);
        ASSERT_LE(static_cast<std::size_t>(offset) + 6, station.bytes());
        ASSERT_TRUE(station.holds(offset, u, upper)) << size.width << ": " << u << ", " << upper;
        ASSERT_EQ(station.part().place_of(offset), (RayPlace{u, upper}));
        const std::int32_t plain =
            ray_offset(station.part().layout_without(), doublings, u, upper, size.height);
        ASSERT_EQ(plain, 3 * (u * size.height + upper));
      }
    }
    EXPECT_EQ(levels.contains(4), size.width >= 512 && size.width % 16 == 0) << size.width;
  }
}

TEST(PolarPart, TakesASmallShareOfTheRays) {
  for (const int width : {1024, 4096, 8192, 32768}) {
    const int columns = PolarPart({width, width / 2}).columns();
    EXPECT_GT(columns, 0.05 * width);
    EXPECT_LT(columns, 0.07 * width);
  }
}

TEST(PolarPart, IsEmptyWhereNoColumnIsSkipped) {
  EXPECT_EQ(PolarPart({8, 4}).columns(), 0);
  EXPECT_EQ(PolarPart({1025, 512}).columns(), 0);
}

}  // namespace
}  // namespace raywalk
