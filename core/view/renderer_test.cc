// Options, sizes and threads of the renderer. renderer_quality_test.cc tests the accuracy.
#include "core/view/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Generation, NamesAreReadBack) {
  for (const Generation generation : kGenerations) {
    EXPECT_EQ(generation_from_name(generation_name(generation)), generation);
  }
  EXPECT_THAT([] { generation_from_name("best"); },
              ThrowsMessage<UsageError>(AllOf(HasSubstr("'best'"), HasSubstr("two-sided"))));
}

class RendererTest : public testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec;
    spec.overhang_m = 0.25;
    return spec;
  }
  // The captured frame of the station at plan position x on the front line.
  cv::Mat front_frame(double x_m) const { return room_.truth({x_m, 0.5}); }

  TestRoom room_{spec()};
};

TEST_F(RendererTest, RefusesOptionsOutOfRange) {
  for (const ViewOptions& options : std::vector<ViewOptions>{{.k_deg = 44.9},
                                                             {.k_deg = 90.1},
                                                             {.k_deg = std::nan("")},
                                                             {.overlap_deg = -0.1},
                                                             {.overlap_deg = 46.0},
                                                             {.layers = -1},
                                                             {.width = 2},
                                                             {.width = 129},
                                                             {.width = -4},
                                                             {.width = 1 << 20}}) {
    EXPECT_THROW(Renderer(room_.room(), options), UsageError);
  }
}

TEST_F(RendererTest, RejectsViewpointsOutsideTheRoom) {
  Renderer renderer(room_.room(), {});
  EXPECT_THROW(renderer.render({std::nan(""), 0.0}), UsageError);
  EXPECT_THROW(renderer.render({0.0, INFINITY}), UsageError);
  EXPECT_THAT(
      [&] {
        renderer.render({0.75, 0.0});
      },
      ThrowsMessage<Error>(HasSubstr("0.75,0 m is outside")));
  EXPECT_NO_THROW(renderer.render({0.0, 0.0})) << "it can go on after a refusal";
}

TEST_F(RendererTest, RefusesCorrectionWithoutDistancesAndNamesTheRemedy) {
  SyntheticRoomSpec bare = spec();
  bare.distances = false;
  const TestRoom room(bare);
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    EXPECT_THAT([&] { Renderer(room.room(), {.generation = generation}); },
                ThrowsMessage<Error>(HasSubstr("raywalk-build-lf depth")));
  }
  EXPECT_NO_THROW(room.view({.generation = Generation::kInitial}, {0.0, 0.0}));
}

TEST_F(RendererTest, InitialViewAtAStationIsItsFrameWhereTheLineIsInFront) {
  // At k = 90 the front line serves -90..90 degrees less half the blend.
  const cv::Range in_front(128 / 4 + 2, 3 * 128 / 4 - 2);
  for (const double x : {-0.375, 0.0, 0.125}) {
    const cv::Mat view = room_.image({.generation = Generation::kInitial}, {x, 0.5});
    EXPECT_EQ(largest_difference(view.colRange(in_front), front_frame(x).colRange(in_front)), 0.0);
  }
}

TEST_F(RendererTest, InitialViewAtACornerIsItsFrameExceptTheCellsQuadrant) {
  // Station and corner coincide at (0.5, 0.5); the rays into the cell, -180..-90 degrees, are read
  // from the lines opposite.
  const cv::Mat view = room_.image({.generation = Generation::kInitial}, {0.5, 0.5});
  const cv::Range out_of_cell(128 / 4 + 2, 126);
  EXPECT_EQ(largest_difference(view.colRange(out_of_cell), front_frame(0.5).colRange(out_of_cell)),
            0.0);
}

TEST_F(RendererTest, InitialViewBetweenStationsIsTheirMean) {
  const cv::Range in_front(128 / 4 + 2, 3 * 128 / 4 - 2);
  cv::Mat mean;
  cv::addWeighted(front_frame(0.0), 0.5, front_frame(0.125), 0.5, 0.0, mean);
  const cv::Mat view = room_.image({.generation = Generation::kInitial}, {0.0625, 0.5});
  EXPECT_LE(largest_difference(view.colRange(in_front), mean.colRange(in_front)), 1.0);
}

TEST_F(RendererTest, CorrectedViewsAtAStationAreItsFrame) {
  const cv::Range in_front(128 / 4 + 2, 3 * 128 / 4 - 2);
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    const cv::Mat view = room_.image({.generation = generation}, {0.125, 0.5});
    EXPECT_LE(largest_difference(view.colRange(in_front), front_frame(0.125).colRange(in_front)),
              1.0)
        << generation_name(generation);
  }
}

TEST_F(RendererTest, PictureDoesNotDependOnThreadsOrOnWhatWasRenderedBefore) {
  for (const Generation generation : kGenerations) {
    Renderer renderer(room_.room(), {.generation = generation, .k_deg = 76.0});
    set_thread_count(2);
    const cv::Mat first = renderer.render({0.2, -0.1}).image;
    renderer.render({-0.4, 0.3});
    const cv::Mat again = renderer.render({0.2, -0.1}).image;
    set_thread_count(1);
    const cv::Mat alone = renderer.render({0.2, -0.1}).image;
    set_thread_count(0);
    EXPECT_EQ(largest_difference(first, again), 0.0) << generation_name(generation);
    EXPECT_EQ(largest_difference(first, alone), 0.0) << generation_name(generation);
  }
}

TEST_F(RendererTest, ReportsLayersAndLimitedCorners) {
  const PlanPoint at{0.3, 0.1};
  EXPECT_EQ(room_.view({.generation = Generation::kInitial}, at).report.layers, 0);
  EXPECT_EQ(room_.view({.layers = 7}, at).report.layers, 7);
  EXPECT_GT(room_.view({}, at).report.layers, 1);
  // 0.25 m of overhang is enough at k = 90, not for LFU.
  EXPECT_EQ(room_.view({.k_deg = 90.0}, at).report.limited_corners, 0);
  EXPECT_GT(room_.view({.k_deg = 45.0}, at).report.limited_corners, 0);
}

TEST_F(RendererTest, TighterToleranceNeedsMoreLayers) {
  const int coarse = room_.view({.tolerance_px = 1.0}, {0.0, 0.0}).report.layers;
  EXPECT_GT(room_.view({.tolerance_px = 0.25}, {0.0, 0.0}).report.layers, 3 * coarse);
}

TEST_F(RendererTest, SmallerPictureIsTheFullOneAveraged) {
  for (const int width : {64, 32, 48}) {
    const cv::Mat full = room_.image({}, {0.1, 0.1});
    cv::Mat reduced;
    cv::resize(full, reduced, {width, width / 2}, 0, 0, cv::INTER_AREA);
    const cv::Mat view = room_.image({.width = width}, {0.1, 0.1});
    ASSERT_EQ(view.size(), reduced.size());
    EXPECT_GT(psnr_db(view, reduced), 40.0) << width;
  }
}

TEST_F(RendererTest, LargerPictureShowsTheSameRoom) {
  for (const Generation generation : kGenerations) {
    const cv::Mat view = room_.image({.generation = generation, .width = 320}, {0.1, 0.1});
    ASSERT_EQ(view.size(), cv::Size(320, 160));
    cv::Mat reduced;
    cv::resize(view, reduced, {128, 64}, 0, 0, cv::INTER_AREA);
    EXPECT_GT(psnr_db(reduced, room_.image({.generation = generation}, {0.1, 0.1})), 33.0);
  }
}

TEST(RendererSizes, TinyPanoramasRender) {
  for (const int width : {4, 8, 12, 20}) {
    SyntheticRoomSpec spec;
    spec.width = width;
    const TestRoom room(spec);
    for (const Generation generation : kGenerations) {
      for (const int out : {0, 4, 8, 40}) {
        const RenderedView view = room.view({.generation = generation, .width = out}, {0.1, 0.5});
        const int columns = out > 0 ? out : width;
        EXPECT_EQ(view.image.size(), cv::Size(columns, columns / 2));
        EXPECT_EQ(view.report.empty_share, 0.0);
      }
    }
  }
}

// A single line through the origin along x, 1.5 m long, and no cell: the paper's 3D360.
class SingleLineRoom : public testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec;
    spec.cells_z = 0;
    spec.overhang_m = 0.25;
    return spec;
  }
  TestRoom room_{spec()};
};

// From 0.5 m before its middle the line is seen under +- atan(0.75 / 0.5) around the centre. The
// two-sided view shows the opposite columns too: the line behind lies in the same vertical plane.
TEST_F(SingleLineRoom, CountsTheColumnsItsLineDoesNotServe) {
  const double served = std::atan(1.5) / kPi;
  for (const Generation generation : kGenerations) {
    const RenderedView view = room_.view({.generation = generation}, {0.0, -0.5});
    const double shown = generation == Generation::kTwoSided ? 2.0 * served : served;
    EXPECT_NEAR(view.report.empty_share, 1.0 - shown, 2.0 / 128.0);

    const cv::Range ahead(46, 82);
    const double db = psnr_db(view.image.colRange(ahead), room_.truth({0.0, -0.5}).colRange(ahead));
    EXPECT_GT(db, generation == Generation::kInitial ? 12.0 : 35.0);
  }
}

// What the line's stations see of them is shown, though the plan reads no line there.
TEST_F(SingleLineRoom, FillsTheColumnsItsLineDoesNotServe) {
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    const RenderedView view = room_.view({.generation = generation}, {0.0, -0.5});
    EXPECT_GT(psnr_db(view.image, room_.truth({0.0, -0.5})), 25.0) << generation_name(generation);
  }
  // Without distances they are filled from the columns beside them, smoothly.
  const cv::Mat initial = room_.image({.generation = Generation::kInitial}, {0.0, -0.5});
  EXPECT_LT(largest_difference(initial.col(2), initial.col(3)), 8.0);
}

TEST_F(SingleLineRoom, ServesEverythingFromTheLineItself) {
  for (const Generation generation : kGenerations) {
    const RenderedView view = room_.view({.generation = generation}, {0.125, 0.0});
    EXPECT_EQ(view.report.empty_share, 0.0);
    EXPECT_LE(largest_difference(view.image, room_.truth({0.125, 0.0})), 1.0);
  }
}

TEST_F(SingleLineRoom, RefusesAViewpointInLineWithIt) {
  EXPECT_THROW(room_.view({}, {1.5, 0.0}), Error);
}

}  // namespace
}  // namespace raywalk
