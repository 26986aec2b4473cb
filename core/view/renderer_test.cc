// Options, sizes, threads and lines of the renderer. renderer_quality_test.cc tests the accuracy.
#include "core/view/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/test_error.h"
#include "core/view/column_sources.h"
#include "core/view/prepared_view.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

using testing::HasSubstr;

class RendererTest : public testing::Test {
 protected:
  // The captured frame of the station at plan position x on the front line.
  cv::Mat front_frame(double x_m) const { return room_.truth({x_m, 0.5}); }

  TestRoom room_{box_room(128)};
};

TEST_F(RendererTest, RefusesOptionsOutOfRangeAndViewpointsOutsideTheRoom) {
  for (const ViewOptions& options :
       std::vector<ViewOptions>{{.k_deg = 44.9}, {.width = 129}, {.stations_mixed = 17}}) {
    EXPECT_THROW(Renderer(room_.room(), options), UsageError);
  }
  Renderer renderer(room_.room(), {});
  EXPECT_THROW(renderer.render({std::nan(""), 0.0}), UsageError);
  EXPECT_THROW(renderer.render({0.0, INFINITY}), UsageError);
  EXPECT_THAT(error_of([&] { renderer.render({0.75, 0.0}); }), HasSubstr("0.75,0 m is outside"));
  EXPECT_NO_THROW(renderer.render({0.0, 0.0})) << "it can go on after a refusal";
}

TEST_F(RendererTest, RefusesCorrectionWithoutDistancesAndNamesTheRemedy) {
  SyntheticRoomSpec bare = box_room(64);
  bare.distances = false;
  const TestRoom room(bare);
  for (const ViewMethod method : kCorrected) {
    EXPECT_THAT(error_of([&] { Renderer(room.room(), {.method = method}); }),
                HasSubstr("raywalk-build-lf depth"));
  }
  EXPECT_NO_THROW(room.view({.method = ViewMethod::kInitial}, {0.0, 0.0}));
}

TEST_F(RendererTest, AtAStationViewsAreItsFrame) {
  // At k = 90 the front line serves -90..90 degrees less half the blend.
  const cv::Range in_front(128 / 4 + 2, 3 * 128 / 4 - 2);
  for (const double x : {-0.375, 0.125}) {
    for (const ViewMethod method : kViewMethods) {
      const cv::Mat view = room_.image({.method = method}, {x, 0.5});
      EXPECT_LE(largest_difference(view.colRange(in_front), front_frame(x).colRange(in_front)),
                method == ViewMethod::kInitial ? 0.0 : 1.0)
          << method_name(method);
    }
  }
  // Station and corner coincide at (0.5, 0.5); the rays into the cell, -180..-90 degrees, are read
  // from the lines opposite.
  const cv::Mat view = room_.image({.method = ViewMethod::kInitial}, {0.5, 0.5});
  const cv::Range out_of_cell(128 / 4 + 2, 126);
  EXPECT_EQ(largest_difference(view.colRange(out_of_cell), front_frame(0.5).colRange(out_of_cell)),
            0.0);
}

TEST_F(RendererTest, InitialViewBetweenStationsIsTheirMean) {
  const cv::Range in_front(128 / 4 + 2, 3 * 128 / 4 - 2);
  cv::Mat mean;
  cv::addWeighted(front_frame(0.0), 0.5, front_frame(0.125), 0.5, 0.0, mean);
  const cv::Mat view = room_.image({.method = ViewMethod::kInitial}, {0.0625, 0.5});
  EXPECT_LE(largest_difference(view.colRange(in_front), mean.colRange(in_front)), 1.0);
}

// A pillar, and a dolly that is masked.
SyntheticRoomSpec room_of_everything() {
  SyntheticRoomSpec spec = pillar_spec(96);
  spec.distance_width = 64;
  spec.companion.emplace().hides = [](const std::string&, int, const Eigen::Vector3d& direction) {
    return direction.y() < -0.8;
  };
  return spec;
}

TEST(RendererThreads, PicturesDoNotDependOnThemOrOnWhatWasRenderedBefore) {
  const TestRoom room(room_of_everything());
  std::vector<ViewOptions> all{{.method = ViewMethod::kInitial}};
  for (const ViewMethod method : kCorrected) {
    for (const int stations : {1, 8}) {
      for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
        all.push_back({.method = method,
                       .k_deg = 76.0,
                       .interpolation = interpolation,
                       .stations_mixed = stations});
      }
    }
  }
  for (const ViewOptions& options : all) {
    Renderer renderer(room.room(), options);
    const auto rendered = [&] {
      cv::Mat both = renderer.render_stereo(PlanPoint{0.2, -0.1}, 0.063).image;
      both.push_back(renderer.render(PlanPoint{0.2, -0.1}).image);
      return both;
    };
    set_thread_count(3);
    const cv::Mat first = rendered();
    renderer.render({-0.4, 0.3});
    const cv::Mat again = rendered();
    set_thread_count(1);
    const cv::Mat alone = rendered();
    set_thread_count(0);
    EXPECT_EQ(largest_difference(first, again), 0.0) << text_of(options);
    EXPECT_EQ(largest_difference(first, alone), 0.0) << text_of(options);
  }
}

TEST(PreparedView, OfThePlansOwnLinesIsTheViewAndBlackWithoutLines) {
  for (const ViewMethod method : kViewMethods) {
    const ViewOptions options{.method = method, .k_deg = 76.0};
    Renderer renderer(pillar_room().room(), options);
    const cv::Mat view = renderer.render({-0.1, -0.15}).image;
    PreparedView& prepared = renderer.prepare({-0.1, -0.15});
    const PanoramaPart whole{.columns = view.cols, .rows = {0, view.rows}};
    prepared.look_at(whole, [&](double theta_rad) {
      return theta_rad < 0.0 ? column_sources(prepared.plan().column(theta_rad), options)
                             : ColumnSources();
    });
    cv::Mat image;
    cv::Mat1b unread;
    PixelCounts counts;
    PreparedView::render(std::array{&prepared}, whole, nullptr, nullptr, &image, &unread, &counts);
    const cv::Range left(0, view.cols / 2), right(view.cols / 2, view.cols);
    EXPECT_EQ(largest_difference(image.colRange(left), view.colRange(left)), 0.0)
        << method_name(method);
    EXPECT_EQ(cv::norm(image.colRange(right)), 0.0) << method_name(method);
  }
}

TEST_F(RendererTest, SmallerPictureIsTheFullOneAveragedAndALargerOneShowsTheSame) {
  for (const ViewMethod method : kViewMethods) {
    const cv::Mat full = room_.image({.method = method}, {0.1, 0.1});
    for (const int width : {64, 32, 320}) {
      const cv::Mat view = room_.image({.method = method, .width = width}, {0.1, 0.1});
      ASSERT_EQ(view.size(), cv::Size(width, width / 2));
      const cv::Size least(std::min(width, 128), std::min(width, 128) / 2);
      cv::Mat reduced, full_reduced;
      cv::resize(view, reduced, least, 0, 0, cv::INTER_AREA);
      cv::resize(full, full_reduced, least, 0, 0, cv::INTER_AREA);
      EXPECT_GT(psnr_db(reduced, full_reduced), width < 128 ? 40.0 : 33.0) << width;
    }
  }
}

TEST(RendererSizes, TinyMapsPanoramasAndPicturesRender) {
  for (const int width : {4, 8, 12, 20}) {
    SyntheticRoomSpec spec = box_room(width);
    spec.scene.contrast = 0.0;
    spec.distance_width = width / 2;
    const TestRoom room(spec);
    for (const ViewMethod method : kViewMethods) {
      for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
        for (const int out : {4, 8, 40}) {
          const cv::Mat view = room.image(
              {.method = method, .width = out, .interpolation = interpolation}, {0.1, 0.5});
          const cv::Mat grey(out / 2, out, CV_8UC3, cv::Scalar::all(128));
          EXPECT_EQ(largest_difference(view, grey), 0.0) << width << " to " << out;
        }
      }
    }
  }
  const TestRoom room(box_room(128));
  const RenderedView large = room.view({.method = ViewMethod::kInitial, .width = 8192}, {0.1, 0.2});
  EXPECT_EQ(large.image.size(), cv::Size(8192, 4096));
  EXPECT_EQ(large.report.empty_share, 0.0);
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
// The other columns are filled: with what its stations see, or smoothly.
TEST_F(SingleLineRoom, CountsAndFillsTheColumnsItsLineDoesNotServe) {
  const double served = std::atan(1.5) / kPi;
  const cv::Mat truth = room_.truth({0.0, -0.5});
  for (const ViewMethod method : kViewMethods) {
    const RenderedView view = room_.view({.method = method}, {0.0, -0.5});
    const double shown = method == ViewMethod::kTwoSided ? 2.0 * served : served;
    EXPECT_NEAR(view.report.empty_share, 1.0 - shown, 2.0 / 128.0);
    if (method == ViewMethod::kInitial) {
      EXPECT_LT(largest_difference(view.image.col(2), view.image.col(3)), 8.0);
      continue;
    }
    const cv::Range ahead(46, 82);
    EXPECT_GT(psnr_db(view.image.colRange(ahead), truth.colRange(ahead)), 35.0);
    EXPECT_GT(psnr_db(view.image, truth), 25.0) << method_name(method);
  }
}

TEST_F(SingleLineRoom, ServesEverythingFromTheLineItselfAndNothingInLineWithIt) {
  for (const ViewMethod method : kViewMethods) {
    const RenderedView view = room_.view({.method = method}, {0.125, 0.0});
    EXPECT_EQ(view.report.empty_share, 0.0);
    EXPECT_LE(largest_difference(view.image, room_.truth({0.125, 0.0})), 1.0);
  }
  EXPECT_THROW(room_.view({}, {1.5, 0.0}), Error);
}

}  // namespace
}  // namespace raywalk
