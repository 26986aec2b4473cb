// Views that skip work: the second side where it is not needed, and everything that skip_px allows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/renderer.h"
#include "core/view/sample_reader.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"
#include "core/view/touched_rays.h"

namespace raywalk {
namespace {

constexpr SecondSide kSides[] = {SecondSide::kBlend, SecondSide::kWhereHidden};
const std::vector<PlanPoint> kSkipViewpoints = {{0.0, 0.0},   {0.23, 0.31}, {-0.31, 0.12},
                                                {0.125, 0.5}, {0.5, 0.5},   {0.02, 0.47}};

// Stations close together, so that there is work to skip, and texture of long wavelength, so that
// differences show positions and not interpolation.
SyntheticRoomSpec dense_room(int distance_width = 192) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = 192;
  spec.spacing_m = 0.03125;
  spec.scene.texture_wavelength_m = 4.0;
  spec.distance_every = 4;
  spec.distance_width = distance_width;
  return spec;
}

// Whether every pixel of `moved` is within the range of the pixels of `picture` up to `move_px`
// away. Neighbouring pixels differ by some 11 grey levels; 4 are allowed for the interpolation at
// other positions.
void expect_moved_by_at_most(const cv::Mat& moved, const cv::Mat& picture, double move_px,
                             const std::string& what) {
  const int radius = static_cast<int>(std::ceil(move_px));
  // Around the seam.
  cv::Mat around, least, most;
  cv::copyMakeBorder(picture, around, 0, 0, radius, radius, cv::BORDER_WRAP);
  const cv::Mat window = cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U);
  cv::erode(around, least, window);
  cv::dilate(around, most, window);
  const cv::Rect middle(radius, 0, picture.cols, picture.rows);
  cv::Mat below, above;
  cv::subtract(least(middle), moved, below);  // saturates: 0 where it is not below
  cv::subtract(moved, most(middle), above);
  EXPECT_LE(cv::norm(below, cv::NORM_INF), 4.0) << what;
  EXPECT_LE(cv::norm(above, cv::NORM_INF), 4.0) << what;
}

TEST(RendererSkip, NothingIsSkippedByDefault) {
  const TestRoom room(dense_room());
  for (const Generation generation : kCorrected) {
    const WorkCounts work = room.view({.generation = generation}, {0.1, 0.2}).report.work;
    EXPECT_EQ(work.uncorrected + work.one_station + work.one_side, 0);
    EXPECT_GT(work.readings, 192 * 96 / 2);
  }
}

TEST(RendererSkip, ATinySkipChangesNothing) {
  // Rows are still split into runs and put together again.
  for (const int distance_width : {192, 96, 48, 64}) {
    const TestRoom room(dense_room(distance_width));
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : kSkipViewpoints) {
        for (const int width : {192, 100}) {
          EXPECT_LE(
              largest_difference(
                  room.image({.generation = generation, .width = width}, at),
                  room.image({.generation = generation, .width = width, .skip_px = 1e-9}, at)),
              1.0)
              << generation_name(generation) << ' ' << distance_width << " at " << at.x_m << ','
              << at.z_m;
        }
      }
    }
  }
}

TEST(RendererSkip, StaysWithinTheLimitAndReadsLessForLargerLimits) {
  for (const int distance_width : {192, 48}) {
    const TestRoom room(dense_room(distance_width));
    for (const Generation generation : kCorrected) {
      for (const PlanPoint at : kSkipViewpoints) {
        const RenderedView all = room.view({.generation = generation}, at);
        WorkCounts before = all.report.work;
        for (const double skip_px : {0.25, 1.0, 3.0}) {
          const RenderedView view = room.view({.generation = generation, .skip_px = skip_px}, at);
          const WorkCounts& work = view.report.work;
          expect_moved_by_at_most(view.image, all.image, skip_px,
                                  generation_name(generation) + " skip " + std::to_string(skip_px));
          EXPECT_LE(work.found, before.found);
          EXPECT_GE(work.uncorrected, before.uncorrected);
          before = work;
        }
        EXPECT_LT(before.found, all.report.work.found * 3 / 4);
        EXPECT_GT(before.uncorrected, 0);
        EXPECT_GT(before.one_station, 0);
        EXPECT_EQ(before.one_side > 0, generation == Generation::kTwoSided);
      }
    }
  }
}

// A second station and a second side are skipped with a margin for wrong distances.
TEST(RendererSkip, StaysWithinTheLimitWhereDistancesAreHalved) {
  SyntheticRoomSpec spec = dense_room(96);
  spec.stored_distance = [](int, int, double exact_m) { return static_cast<float>(0.5 * exact_m); };
  const TestRoom room(spec);
  for (const Generation generation : kCorrected) {
    for (const PlanPoint at : kSkipViewpoints) {
      const cv::Mat all = room.image({.generation = generation}, at);
      for (const double skip_px : {0.5, 2.0}) {
        expect_moved_by_at_most(room.image({.generation = generation, .skip_px = skip_px}, at), all,
                                skip_px, generation_name(generation));
      }
    }
  }
}

TEST(RendererSkip, AViewFromAStationIsItsFrame) {
  const TestRoom room(dense_room());
  const PlanPoint at_station{0.125, 0.5};
  const RenderedView view = room.view({.overlap_deg = 0.0, .skip_px = 0.01}, at_station);
  // Everything in front is read from stored columns of one station, without computed positions.
  EXPECT_GT(view.report.work.uncorrected, view.report.work.readings / 3);
  EXPECT_EQ(view.report.work.found, 2 * (view.report.work.readings - view.report.work.uncorrected) -
                                        view.report.work.one_station);
}

TEST(RendererSkip, HoldsWithLayersAndOtherWidths) {
  const TestRoom room(dense_room(48));
  for (const Generation generation : kCorrected) {
    for (const int layers : {0, 5}) {
      for (const int width : {192, 100, 384}) {
        const ViewOptions all{.generation = generation, .layers = layers, .width = width};
        ViewOptions some = all;
        some.skip_px = 1.0;
        // A captured pixel is two of the widest picture.
        expect_moved_by_at_most(room.image(some, {0.23, 0.31}), room.image(all, {0.23, 0.31}), 2.0,
                                std::to_string(layers) + " layers, width " + std::to_string(width));
      }
    }
  }
}

TEST(RendererSkip, NothingMaskedIsRead) {
  for (const int distance_width : {192, 48, 64}) {
    SyntheticRoomSpec spec = dense_room(distance_width);
    spec.spacing_m = 0.0625;
    spec.companion = CameraCompanion{
        .hides = [](const std::string& line, int station, const Eigen::Vector3d& direction) {
          return direction.y() < -0.9 || (line == "x1" && station % 3 == 0 && direction.y() < 0.1);
        }};
    const TestRoom room(spec);
    spec.companion->color = {0, 255, 0};
    const TestRoom recoloured(spec);
    for (const Generation generation : kCorrected) {
      for (const SecondSide side : kSides) {
        for (const double skip_px : {0.0, 4.0}) {
          for (const PlanPoint at : {PlanPoint{0.02, 0.47}, {0.125, 0.5}}) {
            const ViewOptions options{
                .generation = generation, .second_side = side, .skip_px = skip_px};
            EXPECT_EQ(largest_difference(room.image(options, at), recoloured.image(options, at)),
                      0.0)
                << generation_name(generation) << ' ' << second_side_name(side);
          }
        }
      }
    }
  }
}

TEST(RendererSkip, ExtremesRender) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = 32;
  for (const auto& metres : {std::pair{1e-6f, 1e8f}, {2.0f, 0.0f}, {1e-6f, 1e-6f}}) {
    spec.stored_distance = [metres](int u, int v, double) {
      return (u / 2 + v / 2) % 2 == 0 ? metres.first : metres.second;
    };
    for (const int distance_width : {32, 8, 24}) {
      spec.distance_width = distance_width;
      const TestRoom room(spec);
      for (const Generation generation : kCorrected) {
        for (const SecondSide side : kSides) {
          for (const int stations : {1, 2}) {
            for (const int width : {4, 32, 64}) {
              for (const PlanPoint at : kSkipViewpoints) {
                const RenderedView view = room.view({.generation = generation,
                                                     .width = width,
                                                     .interpolation = Interpolation::kCubic,
                                                     .stations_mixed = stations,
                                                     .second_side = side,
                                                     .skip_px = 4.0},
                                                    at);
                EXPECT_EQ(view.image.size(), cv::Size(width, width / 2));
                EXPECT_EQ(view.report.empty_share, 0.0);
              }
            }
          }
        }
      }
    }
  }
}

// The front line sees nothing below the horizon in one room.
SyntheticRoomSpec room_with_blind_front(int distance_width, bool blind) {
  SyntheticRoomSpec spec = dense_room(distance_width);
  spec.spacing_m = 0.125;
  spec.scene.texture_wavelength_m = 0.5;
  spec.companion = CameraCompanion{
      .hides = [blind](const std::string& line, int, const Eigen::Vector3d& direction) {
        return blind && line == "x1" && direction.y() < -0.1;
      }};
  return spec;
}

TEST(RendererSecondSide, IsReadOnlyWhereTheNearerDoesNotSee) {
  for (const int distance_width : {192, 48}) {
    const TestRoom room(room_with_blind_front(distance_width, true));
    const PlanPoint at{0.0, 0.3};  // nearer to the front line
    const ViewOptions blending{.generation = Generation::kTwoSided};
    ViewOptions where_hidden = blending;
    where_hidden.second_side = SecondSide::kWhereHidden;
    const RenderedView both = room.view(blending, at);
    const RenderedView one = room.view(where_hidden, at);
    const cv::Mat front = room.image({.generation = Generation::kHlfVd}, at);
    // Within 30 degrees of straight ahead, away from the mask's border and from the polar caps,
    // where columns of one source may be the mean of their neighbours.
    const cv::Rect below(80, 66, 32, 30);
    const cv::Rect above(80, 34, 32, 10);
    EXPECT_LE(largest_difference(one.image(below), both.image(below)), 1.0);
    EXPECT_LE(largest_difference(one.image(above), front(above)), 1.0);
    EXPECT_GT(largest_difference(one.image(above), both.image(above)), 1.0);
    EXPECT_LT(one.report.work.samples, both.report.work.samples * 2 / 3);
    EXPECT_GT(one.report.work.one_side, one.report.pixels / 3);
    EXPECT_LT(one.report.work.one_side, one.report.pixels);
  }
}

TEST(RendererSecondSide, WhereHiddenFillsWhatIsHiddenFromTheFront) {
  SyntheticRoomSpec spec = dense_room();
  spec.spacing_m = 0.125;
  spec.scene.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}};
  const TestRoom room(spec);
  const PlanPoint at{0.0, 0.1};
  const ViewOptions where_hidden{.generation = Generation::kTwoSided,
                                 .second_side = SecondSide::kWhereHidden};
  const RenderedView front = room.view({.generation = Generation::kHlfVd}, at);
  const RenderedView both = room.view({.generation = Generation::kTwoSided}, at);
  const RenderedView one = room.view(where_hidden, at);
  EXPECT_EQ(one.report.filled_share, both.report.filled_share);
  EXPECT_LT(one.report.filled_share, front.report.filled_share);
  EXPECT_GT(psnr_db(one.image, room.truth(at)), 38.0);
}

TEST(TouchedRays, CountsEveryCacheLineOnce) {
  SyntheticRoomSpec spec;
  spec.width = 64;
  const TestRoom room(spec);
  TouchedRays touched(room.room());
  EXPECT_EQ(touched.bytes(), 0);
  const std::uint8_t* column = room.room().volume(1).column(3, 7).data();
  const std::uint8_t* line = column + 64 - reinterpret_cast<std::uintptr_t>(column) % 64;
  touched.mark(1, line, 1);
  touched.mark(1, line + 63, 1);
  EXPECT_EQ(touched.bytes(), 64);
  touched.mark(1, line - 1, 2);
  EXPECT_EQ(touched.bytes(), 128);
  touched.mark(1, line - 1, 200);
  EXPECT_EQ(touched.bytes(), 64 * 5);
  touched.mark(0, room.room().volume(0).column(0, 0).data(), 1);
  EXPECT_EQ(touched.bytes(), 64 * 6);
  touched.clear();
  EXPECT_EQ(touched.bytes(), 0);
}

TEST(TouchedRays, SamplesTouchTheColumnsAroundThem) {
  SyntheticRoomSpec spec;
  spec.width = 64;
  const TestRoom room(spec);
  const LineVolume& volume = room.room().volume(1);
  PositionArrays arrays(1);
  const int column_bytes = 3 * volume.panorama().height;
  arrays.offset_left[0] = 8 * column_bytes + 3 * 5;
  arrays.offset_right[0] = 24 * column_bytes + 3 * 5;  // not the next one, as towards a pole
  const StationSamples at{.rays = volume.column(3, 0).data(), .positions = arrays.positions()};
  TouchedRays touched(room.room()), expected(room.room());
  SampleReader reader(room.room(), Interpolation::kLinear, &touched);
  std::uint8_t rgb[4];
  reader.mix({.line = 1, .count = 1, .station = {3}, .at = {at}, .rows = 1}, rgb);
  expected.mark(1, volume.column(3, 8).data() + 3 * 5, 6);
  expected.mark(1, volume.column(3, 24).data() + 3 * 5, 6);
  EXPECT_EQ(touched.bytes(), expected.bytes());
  // Both are marked already: no other line was touched, and neither was missed.
  touched.mark(1, volume.column(3, 8).data() + 3 * 5, 6);
  touched.mark(1, volume.column(3, 24).data() + 3 * 5, 6);
  EXPECT_EQ(touched.bytes(), expected.bytes());
}

TEST(TouchedRays, ViewsTouchTheirColumnsAndSamples) {
  SyntheticRoomSpec spec = dense_room();
  const TestRoom room(spec);
  const auto report_of = [&](const ViewOptions& options) {
    Renderer renderer(room.room(), options);
    renderer.count_bytes(true);
    renderer.render({0.31, -0.2});
    return renderer.render({0.1, 0.2}).report;  // of this view only
  };
  // An initial view reads each column once: whole lines of its 288 bytes.
  const ViewReport initial = report_of({.generation = Generation::kInitial});
  EXPECT_GE(initial.bytes_touched, 3 * initial.work.samples);
  EXPECT_LE(initial.bytes_touched, 3 * initial.work.samples * 384 / 288);
  const auto bytes = [&](Interpolation way, int stations) {
    return report_of({.interpolation = way, .stations_mixed = stations}).bytes_touched;
  };
  EXPECT_LT(bytes(Interpolation::kNearest, 2), bytes(Interpolation::kLinear, 2));
  EXPECT_LT(bytes(Interpolation::kLinear, 2), bytes(Interpolation::kCubic, 2));
  EXPECT_LT(bytes(Interpolation::kLinear, 1), bytes(Interpolation::kLinear, 2) * 2 / 3);
  EXPECT_EQ(room.view({}, {0.1, 0.2}).report.bytes_touched, 0) << "unless asked for";
}

}  // namespace
}  // namespace raywalk
