#include "build_lf/depth/contradictions.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/seen_surfaces.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::IsEmpty;

constexpr StationIndex kVisited{0, 8};   // the station that sees a person
const cv::Rect kPerson(60, 30, 12, 30);  // in its frame of 128 x 64

SyntheticRoomSpec plain_room() { return room_of_scale(1.0); }

// Paints a person of one colour into the frames of the given stations.
DepthTestRoom::Edit person_in(std::vector<StationIndex> stations, double noise = 0.0) {
  return [stations, noise](StationIndex station, cv::Mat* frame) {
    if (std::ranges::find(stations, station) != stations.end()) {
      (*frame)(kPerson) = cv::Scalar(20, 30, 240);
    }
    if (noise > 0.0) add_noise(station, noise, frame);
  };
}

constexpr PanoramaSize kFrame{128, 64};

class ContradictionsTest : public testing::Test {
 protected:
  // Of all lines, with exact maps at every other station, edited by `edit`.
  static Contradictions contradictions_of(
      const DepthTestRoom& room, const std::function<void(InverseDistanceMap*)>& edit = nullptr) {
    return contradictions_of(room, unit_gain_fields(room.grid()), edit);
  }
  static Contradictions contradictions_of(const DepthTestRoom& room, const GainFields& gains,
                                          const std::function<void(InverseDistanceMap*)>& edit) {
    const DepthPlan plan = plan_depth(room.room(), {.every = 2});
    const LineSearch search =
        contradiction_search(room.room(), plan, gains, [&](StationIndex station) {
          InverseDistanceMap map = exact_map(room, station, plan.size);
          if (edit) edit(&map);
          return map;
        });
    Contradictions all;
    for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
      Contradictions of_line = search(line);
      all.size = of_line.size;
      std::ranges::move(of_line.stations, std::back_inserter(all.stations));
    }
    return all;
  }
  static InverseDistanceMap exact_map(const DepthTestRoom& room, StationIndex station,
                                      PanoramaSize size) {
    const Eigen::Vector3d& position_m = room.grid().station(station).position_m;
    InverseDistanceMap map = true_map(plain_room().scene, position_m, size);
    map.station = station;
    return map;
  }
  // In a room whose station kVisited took `exposure` times the light, as its gain says.
  static Contradictions contradictions_at(double exposure) {
    const DepthTestRoom room(plain_room(), [exposure](StationIndex station, cv::Mat* frame) {
      if (station == kVisited) frame->convertTo(*frame, -1, exposure);
    });
    GainFields gains = unit_gain_fields(room.grid());
    gains[0][8].whole = ColourGain::all(static_cast<float>(1.0 / exposure));
    return contradictions_of(room, gains, nullptr);
  }
  // Share of the pixels of `rect` that are left out of the only station of which anything is.
  static double share_found(const Contradictions& found, cv::Rect rect) {
    if (found.stations.size() != 1 || !(found.stations[0].station == kVisited)) return -1.0;
    return cv::countNonZero(mask_of(found.stations[0])(rect)) / static_cast<double>(rect.area());
  }
  // Upright, 1 where anything is left out.
  static cv::Mat mask_of(const ContradictedStation& found) {
    cv::Mat mask = cv::Mat::zeros(64, 128, CV_8UC1);
    for (size_t i = 0; i < found.runs.size(); i += 4) {
      EXPECT_EQ(found.runs[i], found.station.station);
      mask.col(found.runs[i + 1]).rowRange(found.runs[i + 2], found.runs[i + 3]).setTo(1);
    }
    return mask;
  }
};

TEST_F(ContradictionsTest, AreNoneInARoomWhereNothingMoves) {
  EXPECT_THAT(contradictions_of(DepthTestRoom(plain_room())).stations, IsEmpty());
  EXPECT_THAT(contradictions_of(DepthTestRoom(plain_room(), person_in({}, 4.0))).stations,
              IsEmpty());
}

TEST_F(ContradictionsTest, APersonAtOneStationIsLeftOut) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}));
  const Contradictions found = contradictions_of(room);
  EXPECT_EQ(share_found(found, kPerson), 1.0);
  // Not much more than the person: of the sphere it covers 4.8 %.
  double share = 0.0;
  for (int v = 0; v < 64; ++v) {
    const double solid_angle = std::sin((v + 0.5) * kPi / 64.0) * kPi / 64.0 / 2.0 / 128.0;
    share += solid_angle * cv::countNonZero(mask_of(found.stations.at(0)).row(v));
  }
  EXPECT_LT(share, 0.08);
  EXPECT_GT(share, 0.045);
}

TEST_F(ContradictionsTest, AStationWithoutAMapIsComparedToo) {
  const StationIndex without_map{0, 7};
  const Contradictions found =
      contradictions_of(DepthTestRoom(plain_room(), person_in({without_map})));
  EXPECT_THAT(found.stations, ElementsAre(Field(&ContradictedStation::station, without_map)));
}

TEST_F(ContradictionsTest, APersonWithADistanceOfItsOwnIsLeftOutWithIt) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}));
  const auto nearer = [&](InverseDistanceMap* map) {
    if (!(map->station == kVisited)) return;
    for (const auto [u, v] : pixels_of(kFrame)) {
      if (kPerson.contains({u, v})) map->inverse[pixel_index(u, v, kFrame)] = 1.0f / 0.8f;
    }
  };
  const Contradictions found = contradictions_of(room, nearer);
  EXPECT_GT(share_found(found, kPerson), 0.98);
  // The map gets the wall behind the person.
  const InverseDistanceMap truth = exact_map(room, kVisited, kFrame);
  InverseDistanceMap map = truth;
  nearer(&map);
  show_behind(found, 0.01, &map);
  const auto on_person = [](size_t pixel) {
    return kPerson.contains(cv::Point(pixel / kFrame.height, pixel % kFrame.height));
  };
  EXPECT_GT(share_within(map, truth, 0.05, on_person), 0.95);
}

TEST_F(ContradictionsTest, TheSameInNoisyFrames) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}, 4.0));
  EXPECT_GT(share_found(contradictions_of(room), kPerson), 0.98);
}

// What is clipped agrees with what is brighter.
TEST_F(ContradictionsTest, ExposuresAreComparedAfterTheirGains) {
  EXPECT_THAT(contradictions_at(0.7).stations, IsEmpty());
  EXPECT_THAT(contradictions_at(1.8).stations, IsEmpty()) << "clipped";
}

TEST_F(ContradictionsTest, MaskedPixelsAreNeitherComparedNorBelieved) {
  cv::Mat valid(64, 128, CV_8UC1, cv::Scalar(255));
  valid.rowRange(kPerson.y, 64).setTo(0);
  const DepthTestRoom room(plain_room(), person_in({kVisited}),
                           [&](StationIndex) { return valid; });
  EXPECT_THAT(contradictions_of(room).stations, IsEmpty());
}

constexpr GapLimits kLimits{12.0f, 24.0f};

// Gaps of `level` in a rectangle of a transposed panorama, around the seam.
cv::Mat gaps_in(int theta, int phi, int thetas, int phis, float level) {
  cv::Mat gaps = cv::Mat::zeros(256, 128, CV_32FC1);
  for (int t = theta; t < theta + thetas; ++t) {
    for (int p = phi; p < phi + phis; ++p) gaps.at<float>((t + 256) % 256, p) = level;
  }
  return gaps;
}

int contradicted_pixels(const cv::Mat& gaps) {
  return cv::countNonZero(contradicted_regions(gaps, kLimits));
}

TEST(ContradictedRegions, AreLargeAndStrongWithThePixelsMixedWithThem) {
  const cv::Mat strong = gaps_in(100, 40, 10, 30, 50.0f);
  EXPECT_EQ(cv::boundingRect(contradicted_regions(strong, kLimits)), cv::Rect(38, 98, 34, 14));
  EXPECT_EQ(contradicted_pixels(strong), 34 * 14);
  cv::Mat weak = gaps_in(100, 40, 10, 30, 20.0f);
  EXPECT_EQ(contradicted_pixels(weak), 0) << "weak gaps make no region";
  weak(cv::Rect(50, 102, 5, 5)) = 50.0f;
  EXPECT_EQ(contradicted_pixels(weak), 34 * 14) << "but belong to one";
  EXPECT_EQ(contradicted_pixels(gaps_in(100, 10, 4, 100, 50.0f)), 0) << "thin";
  cv::Mat specks = cv::Mat::zeros(256, 128, CV_32FC1);
  for (int t = 0; t < 256; t += 4) {
    for (int p = 0; p < 128; p += 4) specks.at<float>(t, p) = 100.0f;
  }
  EXPECT_EQ(contradicted_pixels(specks), 0);
  cv::Mat hole = gaps_in(100, 40, 10, 10, 50.0f);
  hole.at<float>(105, 45) = 0.0f;
  EXPECT_EQ(contradicted_pixels(hole), 14 * 14) << "a hole of a single pixel is closed";
}

TEST(ContradictedRegions, AreWholeAcrossTheSeam) {
  const cv::Mat regions = contradicted_regions(gaps_in(-3, 40, 6, 8, 50.0f), kLimits);
  EXPECT_EQ(cv::countNonZero(regions), 10 * 12);
  EXPECT_NE(regions.at<uchar>(0, 44), 0);
  EXPECT_NE(regions.at<uchar>(255, 44), 0);
}

constexpr PanoramaSize kSize{256, 128};

// Inverse distances from `at_m` to the inside of a sphere of radius 1 m about the origin.
float sphere_inverse(const Eigen::Vector3d& direction, const Eigen::Vector3d& at_m) {
  const double along = at_m.dot(direction);
  return static_cast<float>(1.0 / (-along + std::sqrt(along * along + 1.0 - at_m.squaredNorm())));
}

Eigen::Vector3d direction_of(int theta, int phi) {
  return direction_from_angles(angles_from_pixel({double(theta), double(phi)}, kSize));
}

std::vector<float> sphere_map(const Eigen::Vector3d& at_m) {
  std::vector<float> inverse;
  for (const auto [theta, phi] : pixels_of(kSize)) {
    inverse.push_back(sphere_inverse(direction_of(theta, phi), at_m));
  }
  return inverse;
}

TEST(SeenSurfacesTest, AreWhereTheOtherStationSeesThem) {
  const Eigen::Vector3d from_m(0.1, 0.0, -0.2);
  const Eigen::Vector3d to_m(-0.15, 0.05, 0.1);
  const auto seen = seen_surfaces(sphere_map(from_m), kSize, PixelDirections(kSize),
                                  (to_m - from_m).cast<float>());
  size_t found = 0;
  for (const auto [theta, phi] : pixels_of(kSize)) {
    const float inverse = seen[pixel_index(theta, phi, kSize)];
    if (inverse < 0.0f) continue;  // no point fell into this pixel
    ++found;
    // Within half a pixel, on a sphere whose inverse distance changes by less than 1/m per
    // radian.
    ASSERT_NEAR(inverse, sphere_inverse(direction_of(theta, phi), to_m), kTwoPi / kSize.width);
  }
  EXPECT_GT(found, seen.size() / 2);
}

TEST(SeenSurfacesTest, ShowTheNearestAndLeaveOutWhatIsNone) {
  std::vector<float> inverse(size_t(kSize.width) * kSize.height, -1.0f);
  const auto none = seen_surfaces(inverse, kSize, PixelDirections(kSize), {0.3f, 0.0f, 0.0f});
  EXPECT_EQ(std::count(none.begin(), none.end(), -1.0f), std::ptrdiff_t(none.size()));
  // Infinitely far points stay in their pixels wherever the station is.
  std::fill(inverse.begin(), inverse.end(), 0.0f);
  const auto far = seen_surfaces(inverse, kSize, PixelDirections(kSize), {0.3f, 0.0f, 0.0f});
  EXPECT_EQ(far, inverse);
  // 1 m to the right of the map's station; from 0.5 m behind that it hides what is far behind it.
  const size_t right = pixel_index(3 * kSize.width / 4, kSize.height / 2, kSize);
  inverse[right] = 1.0f;
  const auto hidden = seen_surfaces(inverse, kSize, PixelDirections(kSize), {-0.5f, 0.0f, 0.0f});
  EXPECT_NEAR(hidden[right], 1.0 / 1.5, 1e-3);
}

TEST(StationColoursTest, AreARangeWhereAChannelIsDarkOrClipped) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.5;
  const DepthTestRoom room(spec, [](StationIndex, cv::Mat* frame) {
    frame->setTo(cv::Scalar(100, 100, 100));
    frame->at<cv::Vec3b>(10, 20) = {255, 100, 2};  // blue, green, red
  });
  const GainField darker{.whole = {0.5f, 0.5f, 0.5f}};
  const StationColours colours = station_colours(room.room(), {0, 1}, {128, 64}, darker);
  const cv::Mat ranges = ranges_of(colours);
  const ColourRange clipped = range_at(ranges, pixel_index(20, 10, {128, 64}));
  EXPECT_EQ(clipped.least, cv::Vec3b(0, 50, 128));
  EXPECT_EQ(clipped.most, cv::Vec3b(1, 50, 255));
  const ColourRange plain = range_at(ranges, pixel_index(21, 10, {128, 64}));
  EXPECT_EQ(plain.least, cv::Vec3b(50, 50, 50));
  EXPECT_EQ(plain.most, plain.least);
  EXPECT_EQ(colours.shown.at<cv::Vec3b>(21, 10), plain.least);
}

TEST(StationColoursTest, SampledRangesHoldBothSidesOfAnEdgeAndNothingOfAMask) {
  cv::Mat picture(32, 16, CV_8UC3, cv::Scalar(50, 50, 50));
  picture.rowRange(16, 32).setTo(cv::Scalar(150, 150, 150));
  cv::Mat valid(32, 16, CV_8UC1, cv::Scalar(255));
  valid.at<std::uint8_t>(20, 8) = 0;
  const cv::Mat ranges = sampled_ranges({picture, picture, picture}, valid);
  const auto at = [&](int theta, int phi) { return *ranges.ptr<ColourRange>(theta, phi); };
  EXPECT_EQ(ranges.rows, 64);
  EXPECT_EQ(gaps_between(at(16, 16), {{50, 50, 50}, {50, 50, 50}}), 0);
  EXPECT_EQ(gaps_between(at(16, 16), {{150, 50, 50}, {150, 50, 50}}), 100);
  EXPECT_LT(gaps_between(at(31, 16), {{90, 90, 90}, {90, 90, 90}}), 15);
  EXPECT_GT(gaps_between(at(28, 16), {{90, 90, 90}, {90, 90, 90}}), 100);
  EXPECT_TRUE(is_masked(at(40, 16)));
  EXPECT_TRUE(is_masked(at(41, 17)));
  EXPECT_FALSE(is_masked(at(42, 16)));
}

}  // namespace
}  // namespace raywalk::build_lf
