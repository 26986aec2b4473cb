// What stations see of a view, and how pictures are filled where none sees anything.
#include "core/view/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/view/mask_check.h"
#include "core/view/picture_fill.h"
#include "core/view/test_room.h"
#include "core/view/unknown_pixels.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

// Where the pixel (u, v) of a panorama of the given size at `from_m` lies.
Vector3d point_at(const SyntheticScene& scene, const Vector3d& from_m, PixelPosition pixel,
                  PanoramaSize size) {
  const Vector3d direction = direction_from_angles(angles_from_pixel(pixel, size));
  return from_m + direction * distance_at(scene, from_m, direction);
}

// Whether a surface point is seen from a place. Surfaces are told apart that are further apart than
// 1 % of the distance.
bool sees(const SyntheticScene& scene, const Vector3d& from_m, const Vector3d& point_m) {
  const Vector3d ray = point_m - from_m;
  return distance_at(scene, from_m, ray.normalized()) > 0.99 * ray.norm();
}

const std::vector<int> kFourLines = {0, 1, 2, 3};

// The passes of a view up to what its stations see.
class SeenView {
 public:
  SeenView(const TestRoom& room, const Viewpoint& at, const ViewOptions& options)
      : room_(room),
        options_(options),
        plan_(room.room().grid(), at, {kHalfPi, 0.0}),
        eye_m_(plan_.eye().centre_m) {
    distances_.compute(nearest_maps(room.room(), kFourLines, eye_m_, 0.1, 2, 4), eye_m_);
    fill_ = FillStations(room.room(), nearest_maps(room.room(), kFourLines, eye_m_, 0.0, 99, 99));
    compute([this](double theta_rad) { return column_sources(plan_.column(theta_rad), options_); });
  }
  void compute(const Visibility::Sources& sources) {
    visibility_.compute(distances_, {0, size().width}, sources, kFourLines, plan_.above_lines_m(),
                        station_mix(options_), fill_);
  }

  PanoramaSize size() const { return distances_.size(); }
  const ColumnSources& sources(int theta) const { return visibility_.sources(theta); }
  const Visibility& visibility() const { return visibility_; }
  // Where a column's ray meets the line of a source, at the height of the lines.
  Vector3d met_m(int theta, const RaySource& at) const {
    const double theta_rad = theta_of_column(theta, size().width);
    return eye_m_ + Vector3d(at.d_p_m * std::sin(theta_rad), -plan_.above_lines_m(),
                             at.d_p_m * std::cos(theta_rad));
  }
  // What a place sees of the points of a pixel; none at a silhouette.
  std::optional<bool> sees_all(const Vector3d& from_m, int theta, int row) const {
    const SyntheticScene& scene = room_.spec().scene;
    constexpr int kAround = 2;
    int seen = 0, all = 0;
    for (int u = theta - kAround; u <= theta + kAround; ++u) {
      for (int v = row - kAround; v <= row + kAround; ++v, ++all) {
        seen +=
            sees(scene, from_m, point_at(scene, eye_m_, {double(u), double(v)}, size())) ? 1 : 0;
      }
    }
    if (seen != 0 && seen != all) return std::nullopt;
    return seen == all;
  }
  // The same of the pixel's middle; none where the view's distance is wrong.
  std::optional<bool> sees_middle(const Vector3d& from_m, int theta, int row) const {
    const SyntheticScene& scene = room_.spec().scene;
    const Vector3d point_m = point_at(scene, eye_m_, {double(theta), double(row)}, size());
    const double right = (point_m - eye_m_).norm() * distances_.column(theta)[row];
    if (std::fabs(right - 1.0) > 0.02) return std::nullopt;
    return sees(scene, from_m, point_m);
  }

 private:
  const TestRoom& room_;
  ViewOptions options_;
  ViewPlan plan_;
  Vector3d eye_m_;
  DistanceView distances_{room_.room()};
  FillStations fill_;
  Visibility visibility_{room_.room()};
};

struct Found {
  int hidden = 0, seen = 0;                  // in truth
  int wrongly_seen = 0, wrongly_hidden = 0;  // of these

  void add(bool truth, bool found) {
    (truth ? seen : hidden) += 1;
    if (truth != found) (found ? wrongly_seen : wrongly_hidden) += 1;
  }
};

TEST(Visibility, OfTheMapsAroundAStationTheNearerOneTellsMore) {
  const StationOccluders quarter_way{.before = 1, .after = 2, .after_part = 0.25f};
  EXPECT_EQ(seen_part(0, quarter_way), 1.0f);
  EXPECT_EQ(seen_part(1, quarter_way), 0.25f);
  EXPECT_EQ(seen_part(2, quarter_way), 0.75f);
  EXPECT_EQ(seen_part(3, quarter_way), 0.0f);
  EXPECT_EQ(seen_part(4, quarter_way), 1.0f);
  EXPECT_EQ(seen_part(kOccludedInView, quarter_way), 0.0f);
  EXPECT_EQ(seen_part(kOccludedInView, {}), 0.0f);
  EXPECT_EQ(seen_part(1, {}), 1.0f);  // no map tells
  EXPECT_EQ(seen_part(1, {.before = 1, .after = 1}), 0.0f);
}

// Of each station that has a share, where it and the place where the line is met agree.
Found compare_with_truth(const SeenView& view, const TestRoom& room, int mixed) {
  Found found;
  for (int theta = 0; theta < view.size().width; theta += 2) {
    const ColumnSources& sources = view.sources(theta);
    for (std::size_t i = 0; i < sources.count; ++i) {
      const RaySource& at = sources.source[i].at;
      const bool behind = sources.source[i].behind();
      const Line& line = room.room().grid().lines[static_cast<std::size_t>(at.line)];
      const auto* const occluded = view.visibility().occluded(theta, at.line, behind);
      const StationWindow window =
          stations_mixed(at, static_cast<int>(line.stations.size()), {mixed});
      for (int station = window.first; station <= window.last; ++station) {
        const StationOccluders by = view.visibility().occluders(theta, at.line, behind, station);
        const Vector3d& from_m = line.stations[static_cast<std::size_t>(station)].position_m;
        for (int row = 0; row < view.size().height; ++row) {
          const auto truth = view.sees_all(from_m, theta, row);
          if (!truth || view.sees_all(view.met_m(theta, at), theta, row) != truth) continue;
          found.add(*truth, is_seen(occluded[row], by));
        }
      }
    }
  }
  return found;
}

TEST(Visibility, EveryStationSeesAllOfAConvexRoom) {
  const TestRoom room({.overhang_m = 0.25, .width = 32, .distance_width = 128});
  const SeenView view(room, {-0.1, -0.15}, {.method = ViewMethod::kTwoSided});
  const Found found = compare_with_truth(view, room, 1);
  EXPECT_EQ(found.hidden, 0);
  EXPECT_GT(found.seen, 5000);
  EXPECT_EQ(found.wrongly_hidden, 0);
  for (int theta = 0; theta < view.size().width; ++theta) {
    EXPECT_FALSE(view.visibility().any_filled(theta));
  }
}

class VisibilityAtHeights : public testing::TestWithParam<double> {};
// Of the viewpoint above the lines; the pillar ends at 0.4 m.
INSTANTIATE_TEST_SUITE_P(Metres, VisibilityAtHeights, testing::Values(0.0, 0.1, 0.3, -0.3));

TEST_P(VisibilityAtHeights, IsThatOfTheRoomBehindAPillar) {
  static const TestRoom room(pillar_spec(32));
  for (const int mixed : {1, 4}) {
    const SeenView view(room, {PlanPoint{-0.1, -0.15}, GetParam()},
                        {.method = ViewMethod::kTwoSided, .stations_mixed = mixed});
    const Found found = compare_with_truth(view, room, mixed);
    EXPECT_GT(found.hidden, 100);
    EXPECT_GT(found.seen, 5000);
    EXPECT_LE(found.wrongly_seen, found.hidden / 20) << mixed;
    EXPECT_LE(found.wrongly_hidden, found.seen / 200) << mixed;
  }
}

// What the view itself tells, of places ahead of the eye and behind it, below it and above: of a
// wall across the view below the cameras, or hanging from the ceiling.
TEST(Visibility, TheViewTellsWhatIsOccludedFromPlacesInItsColumns) {
  for (const double above_m : {0.05, 0.4, -0.05, -0.4}) {
    const SceneBox wall = above_m < 0.0 ? SceneBox{{-0.9, 0.3, 0.8}, {0.9, 1.5, 0.9}}
                                        : SceneBox{{-0.9, -1.2, 0.8}, {0.9, -0.3, 0.9}};
    const TestRoom room({.scene = {.obstacle = wall},
                         .spacing_m = 0.25,
                         .overhang_m = 0.25,
                         .width = 32,
                         .distance_width = 256});
    SeenView view(room, {PlanPoint{0.05, -0.1}, above_m}, {});
    Found found;
    for (const double d_p_m : {0.4, 0.0, 0.65, -0.3, -0.7}) {
      const RaySource at{.line = 1, .d_p_m = d_p_m};
      view.compute([&](double) {
        ColumnSources sources;
        sources.source[sources.count++].at = at;
        return sources;
      });
      for (int theta = 0; theta < view.size().width; ++theta) {
        const auto* const occluded = view.visibility().occluded(theta, 1, d_p_m < 0.0);
        for (int row = 0; row < view.size().height; ++row) {
          const auto truth = view.sees_middle(view.met_m(theta, at), theta, row);
          if (truth) found.add(*truth, is_seen(occluded[row], {}));
        }
      }
    }
    EXPECT_GT(found.hidden, 100) << above_m;
    EXPECT_LE(found.wrongly_seen, found.hidden / 10) << above_m;
    EXPECT_LE(found.wrongly_hidden, found.seen / 100) << above_m;
  }
}

// A disc to the right and below, or across the seam, is hidden from all stations but one.
CameraCompanion disc(bool masked) {
  return {.hides =
              [](const std::string&, int station, const Vector3d& direction) {
                const Vector3d towards =
                    station == 0 ? Vector3d(0.1, -0.6, -0.8) : Vector3d(0.9, -0.4, 0);
                return station != 2 && direction.dot(towards.normalized()) > 0.9;
              },
          .masked = masked,
          .left_out = !masked};
}

// Whether a pixel of a station may be used, from the room's own runs.
bool pixel_usable(const Room& room, int station, int u, int v) {
  const LineVolume& volume = room.volume(0);
  const RowRun valid = volume.valid_rows(station, u);
  if (v < valid.begin || v >= valid.end) return false;
  const LeftOutPixels& left_out = room.distances(0).left_out();
  if (!left_out.any(station)) return true;
  const PanoramaSize size = volume.panorama(), maps = left_out.size();
  const int row = v * maps.height / size.height;
  return std::ranges::none_of(left_out.rows(station, u * maps.width / size.width),
                              [&](const RowRun& run) { return row >= run.begin && row < run.end; });
}

class MaskCheckTest : public testing::TestWithParam<std::tuple<bool, int, int>> {};

TEST_P(MaskCheckTest, RefusesSamplesThatTouchAPixelThatIsNotToBeUsed) {
  const auto [masked, distance_width, beyond] = GetParam();
  const TestRoom room({.spacing_m = 0.25,
                       .width = 64,
                       .distance_width = distance_width,
                       .companion = disc(masked)});
  EXPECT_TRUE(has_masks(room.room(), 0, 0));
  const PanoramaSize size = room.room().panorama();
  std::mt19937 random(9);
  int refused = 0, used = 0;
  for (int station = 0; station < 3; ++station) {
    MaskCheck check(room.room(), 0, station, beyond);
    for (int n = 0; n < 20000; ++n) {
      // Now down a column, now anywhere.
      const int u = n % 50 == 0 ? static_cast<int>(random() % 64) : n / 100 % size.width;
      const auto v = static_cast<int>(random() % static_cast<unsigned>(size.height - 1));
      bool expected = true;
      for (int x = u - beyond; x <= u + 1 + beyond; ++x) {
        for (int y = v - beyond; y <= v + 1 + beyond; ++y) {
          expected &= pixel_usable(room.room(), station, (x + size.width) % size.width,
                                   std::clamp(y, 0, size.height - 1));
        }
      }
      const int left = 3 * (u * size.height + v);
      const int right = 3 * ((u + 1) % size.width * size.height + v);
      ASSERT_EQ(check.usable(left, right), expected) << station << ": " << u << ", " << v;
      ASSERT_TRUE(masked || check.valid(left, right)) << "only masked ones are not";
      (expected ? used : refused) += 1;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(used, 1000);
}

// With masks; and what is left out, in maps of several sizes. Linear and cubic samples.
INSTANTIATE_TEST_SUITE_P(Rooms, MaskCheckTest,
                         testing::Combine(testing::Bool(), testing::Values(64, 24),
                                          testing::Values(0, 1)));

constexpr int kWidth = 96;
constexpr int kHeight = 48;
const cv::Vec3b kWall(90, 120, 150);
const cv::Vec3b kUnknown(0, 255, 0);

// A picture whose values are not known in a rectangle, and absurd there.
struct HoledPicture {
  cv::Mat1f values = cv::Mat1f(kHeight, kWidth), truth;
  cv::Mat1b unknown = cv::Mat1b::zeros(kHeight, kWidth);

  template <typename ValueAt>
  HoledPicture(const ValueAt& value_at, const cv::Rect& hole) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) values(y, x) = static_cast<float>(value_at(x, y));
    }
    truth = values.clone();
    values(hole) = 1e6f;
    unknown(hole) = 255;
  }
  bool fill(Seam seam) { return fill_unknown(unknown, seam, {0, kHeight}, &values); }
  double largest_error() const { return cv::norm(values, truth, cv::NORM_INF); }
};

TEST(UnknownPixels, AConstantStaysAndARampIsContinued) {
  for (const Seam seam : {Seam::kOpen, Seam::kJoined}) {
    HoledPicture constant([](int, int) { return 7.5; }, {20, 5, 40, 43});
    EXPECT_TRUE(constant.fill(seam));
    EXPECT_LT(constant.largest_error(), 1e-4);
  }
  HoledPicture ramp([](int x, int y) { return 2.0 * x + y; }, {30, 12, 24, 20});
  EXPECT_TRUE(ramp.fill(Seam::kOpen));
  EXPECT_LT(ramp.largest_error(), 4.0);  // of 66 across the hole
}

TEST(UnknownPixels, OneKnownPixelFillsAllAndNoneNothing) {
  HoledPicture picture([](int, int) { return 3.0; }, {0, 0, kWidth, kHeight});
  EXPECT_FALSE(picture.fill(Seam::kJoined));
  EXPECT_EQ(picture.values(5, 7), 1e6f);
  picture.values(31, 77) = 3.0f;
  picture.unknown(31, 77) = 0;
  EXPECT_TRUE(picture.fill(Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-5);
}

// Left of the hole is 0, right of it 100: with the seam joined, a hole across it goes smoothly from
// one to the other; else its border does not reach the other side.
TEST(UnknownPixels, AHoleAcrossTheSeamIsFilledFromBothOfItsSides) {
  HoledPicture picture([](int x, int) { return x < kWidth / 2 ? 0.0 : 100.0; },
                       {0, 0, 12, kHeight});
  const cv::Mat1f before = picture.values.clone();
  EXPECT_TRUE(picture.fill(Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-3);
  before.copyTo(picture.values);
  picture.unknown.colRange(kWidth - 12, kWidth) = 255;
  EXPECT_TRUE(picture.fill(Seam::kJoined));
  const auto at = [&](int x) { return picture.values(kHeight / 2, (x + kWidth) % kWidth); };
  for (int x = -12; x < 12; ++x) EXPECT_LT(std::fabs(at(x) - at(x - 1)), 100.0 / 8.0) << x;
  EXPECT_NEAR(0.5 * (at(-1) + at(0)), 50.0, 3.0);
}

// All columns of a panorama meet at a pole: what is filled there must not depend on the column.
TEST(UnknownPixels, APoleHasOneValue) {
  HoledPicture picture([](int x, int) { return x % 24 < 12 ? 0.0 : 100.0; },
                       {0, kHeight - 16, kWidth, 16});
  EXPECT_TRUE(picture.fill(Seam::kJoined));
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(picture.values.row(kHeight - 1), &least, &most);
  EXPECT_NEAR(least, 50.0, 5.0);
  EXPECT_NEAR(most, 50.0, 5.0);
}

// A panorama with places that were not read, which are green.
struct Picture {
  cv::Mat image = cv::Mat(kHeight, kWidth, CV_8UC3, kWall);
  cv::Mat1b unread = cv::Mat1b::zeros(kHeight, kWidth);

  void forget(const cv::Rect& where) {
    for (int x = where.x; x < where.x + where.width; ++x) {
      const cv::Rect column((x + kWidth) % kWidth, where.y, 1, where.height);
      unread(column) = 255;
      image(column) = kUnknown;
    }
  }
  void fill(Seam seam = Seam::kJoined) { fill_picture(unread, seam, {0, kHeight}, &image); }
  // The largest difference from a colour.
  double off(const cv::Vec3b& color) const {
    return cv::norm(image, cv::Mat(image.size(), CV_8UC3, color), cv::NORM_INF);
  }
};

TEST(PictureFill, PlacesAnywhereTakeTheColourAround) {
  const cv::Rect all(0, 0, kWidth, kHeight);
  for (const cv::Rect& where :
       {cv::Rect(30, 10, 20, 15), cv::Rect(-8, 20, 20, 9), cv::Rect(0, 40, kWidth, 8),
        cv::Rect(5, 0, 2, kHeight), cv::Rect(kWidth - 1, 7, 1, 1), all}) {
    Picture picture;
    picture.forget(where);
    picture.fill();
    EXPECT_EQ(picture.off(where == all ? kUnknown : kWall), 0.0) << where;
  }
}

TEST(PictureFill, PlacesBesideEachOtherDoNotShowInEachOther) {
  Picture picture;
  for (int i = 0; i < 12; ++i) picture.forget({8 * i, 6 + 2 * i, 5, 5});
  picture.forget({40, 20, 30, 20});  // overlaps some of them
  picture.fill();
  EXPECT_EQ(picture.off(kWall), 0.0);
}

TEST(PictureFill, KnownPixelsStay) {
  for (const Seam seam : {Seam::kOpen, Seam::kJoined}) {
    Picture picture;
    cv::randu(picture.image, 0, 255);
    const cv::Mat before = picture.image.clone();
    picture.forget({30, 10, 20, 15});
    picture.forget({-4, 30, 8, 8});
    picture.fill(seam);
    EXPECT_EQ(cv::norm(before, picture.image, cv::NORM_INF, picture.unread == 0), 0.0);
  }
}

TEST(PictureFill, OnlyLargePlacesThatThePartCutsOffAreUnreadAtItsBorder) {
  const auto is_cut_off = [](const cv::Rect& where, Seam seam, ShownRows rows) {
    Picture picture;
    picture.forget(where);
    return is_unread_at_border(picture.unread, seam, rows, 6);
  };
  const ShownRows all{0, kHeight};
  EXPECT_FALSE(is_cut_off({30, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({0, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({kWidth - 20, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_FALSE(is_cut_off({0, 10, 20, 15}, Seam::kJoined, all));
  EXPECT_FALSE(is_cut_off({0, 10, 3, 3}, Seam::kOpen, all));
  // The nadir is not a border.
  EXPECT_FALSE(is_cut_off({30, 30, 20, kHeight - 30}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({30, 30, 20, kHeight - 30}, Seam::kOpen, {0, 2 * kHeight}));
  EXPECT_TRUE(is_cut_off({30, 0, 20, 15}, Seam::kOpen, {kHeight, 2 * kHeight}));
}

}  // namespace
}  // namespace raywalk
