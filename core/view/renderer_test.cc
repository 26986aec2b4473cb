// Options, sizes, threads and lines of the renderer, compressed rooms and very large panoramas;
// renderer_quality_test.cc tests the accuracy.
#include "core/view/renderer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/room/hdf5_file.h"
#include "core/room/tiled_rays.h"
#include "core/view/column_sources.h"
#include "core/view/prepared_view.h"
#include "core/view/test_room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

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
  const TestRoom room({.width = 64, .distances = false});
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
  spec.companion = masked_below(-0.8);
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
    const TestRoom room({.scene = {.contrast = 0.0},
                         .overhang_m = 0.25,
                         .width = width,
                         .distance_width = width / 2});
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
  TestRoom room_{{.cells_z = 0, .overhang_m = 0.25}};
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

constexpr PlanPoint kPlaces[] = {{0.1, -0.05}, {-0.3, 0.35}};

// A limit of the cache for the length of a test.
class CacheLimit {
 public:
  explicit CacheLimit(std::uint64_t bytes) { TileCache::of_process().set_limit_bytes(bytes); }
  ~CacheLimit() { TileCache::of_process().set_limit_bytes(TileCache::default_limit_bytes()); }
};

SyntheticRoomSpec spec_of(RayForm::Kind kind, bool masked) {
  SyntheticRoomSpec spec{.overhang_m = 0.25, .width = 96, .distance_width = 48, .form = {kind, 0}};
  if (masked) spec.companion = masked_below(-0.8);
  return spec;
}

std::vector<ViewOptions> all_options(int width) {
  std::vector<ViewOptions> all;
  for (const ViewMethod method : kViewMethods) {
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
      all.push_back({.method = method, .width = width, .interpolation = interpolation});
    }
  }
  all.push_back({.method = ViewMethod::kTwoSided, .width = 4 * width / 3});
  all.push_back({.method = ViewMethod::kHlfVd, .width = width, .stations_mixed = 8});
  return all;
}

class TiledViewsTest : public testing::TestWithParam<bool> {};

TEST_P(TiledViewsTest, ShowLosslessRaysAsTheRawOnes) {
  const TestRoom raw(spec_of(RayForm::Kind::kRaw, GetParam()));
  const TestRoom tiled(spec_of(RayForm::Kind::kLossless, GetParam()));
  for (const std::uint64_t limit : {std::uint64_t{1} << 32, std::uint64_t{1}}) {
    const CacheLimit limited(limit);
    const TileCounts before = TileCache::of_process().counts();
    for (const ViewOptions& options : all_options(raw.spec().width)) {
      for (const PlanPoint place : kPlaces) {
        EXPECT_EQ(largest_difference(tiled.image(options, place), raw.image(options, place)), 0.0)
            << limit << ' ' << method_name(options.method);
      }
    }
    const TileCounts after = TileCache::of_process().counts();
    if (limit == 1) {
      EXPECT_GT(after.evicted, before.evicted + 1000);
      EXPECT_LE(after.bytes, limit);
    } else {
      EXPECT_GT(after.decoded, before.decoded);
      EXPECT_EQ(after.evicted, before.evicted);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Masked, TiledViewsTest, testing::Bool());

// Panoramas of 400 MB each, the last of a line beyond 2 GB.
constexpr PanoramaSize kPanorama{16384, 8192};
constexpr PanoramaSize kMap{64, 32};

// The colour at infinity in the direction of a pixel. Neighbouring pixels differ by at most one
// level, which bounds the effect of rounding; green and blue distinguish columns and rows over the
// whole picture.
struct Color {
  std::uint8_t red, green, blue;
};
Color color_at(int u, int v) {
  const int aside = std::abs(u - kPanorama.width / 2);  // the same on both sides of the seam
  const int wave = std::abs((aside + v) % 510 - 255);
  const int turn = aside / 32;
  return {static_cast<std::uint8_t>(wave), static_cast<std::uint8_t>(std::min(turn, 255)),
          static_cast<std::uint8_t>(v / 32)};
}

// A dataset of which only the last station's values are written; the file has a hole before them.
template <typename Value>
void write_last(Hdf5File* file, const char* name, ElementType type, const Shape& shape,
                const std::vector<Value>& slab) {
  file->create_contiguous(name, type, shape);
  file->write_slab(name, shape.front() - 1, slab.data());
}

// One line of seven stations that see an infinitely far scene.
Room write_large_room(const std::filesystem::path& directory) {
  const Grid grid = synthetic_grid({.cells_z = 0, .spacing_m = 1.0 / 6.0});
  std::filesystem::create_directories(directory / "lines");
  std::filesystem::create_directories(distances_directory(directory, DistanceKind::kGiven));
  {
    std::vector<std::uint8_t> rays;
    rays.reserve(std::size_t{3} * kPanorama.width * kPanorama.height);
    for (int u = 0; u < kPanorama.width; ++u) {
      for (int v = 0; v < kPanorama.height; ++v) {
        const Color color = color_at(u, v);
        rays.insert(rays.end(), {color.red, color.green, color.blue});
      }
    }
    Hdf5File file = Hdf5File::create(line_volume_path(directory, grid.lines[0].id));
    file.write_format(kLineVolumeFormat);
    write_last(&file, "rays", ElementType::kUint8, {7, kPanorama.width, kPanorama.height, 3}, rays);
    file.close();
  }
  const std::size_t pixels = std::size_t{kMap.width} * std::size_t{kMap.height};
  Hdf5File file = Hdf5File::create(distance_volume_path(directory, grid.lines[0].id));
  file.write_format(kDistanceVolumeFormat);
  file.write("station", std::vector<std::int32_t>{6});
  write_last(&file, "distance_m", ElementType::kFloat32, {1, kMap.width, kMap.height},
             std::vector<float>(pixels, std::numeric_limits<float>::infinity()));
  write_last(&file, "confidence", ElementType::kUint8, {1, kMap.width, kMap.height},
             std::vector<std::uint8_t>(pixels, 255));
  file.close();
  write_file_atomically(manifest_path(directory),
                        manifest_to_json({kPanorama, grid, {}, DistanceKind::kGiven}));
  return Room::open(directory);
}

TEST(RendererLarge, PanoramasOf16384ColumnsAreReadAtTheRightPositions) {
  const TestDirectory directory;
  const double disk_bytes = static_cast<double>(std::filesystem::space(directory.path()).available);
  if (disk_bytes < 1e9) GTEST_SKIP() << "needs 1 GB of disk";
  const Room room = write_large_room(directory / "room.lf");
  for (const ViewMethod method : {ViewMethod::kInitial, ViewMethod::kHlfVd}) {
    // From the last station, which is read in all directions: ahead, across the seam, to the last
    // rows.
    Renderer renderer(room, {.method = method});
    for (const auto& [yaw_deg, pitch_deg] :
         {std::pair{0.3, 0.2}, {-180.0, 5.0}, {179.0, -83.0}, {-70.0, 88.0}}) {
      // About as fine as the panorama.
      const Viewport viewport = looking(yaw_deg, pitch_deg, 10.0, 2.2, 100, 80);
      const cv::Mat picture = renderer.render({0.5, 0.0}, viewport).image;
      int worst = 0;
      for (int v = 0; v < picture.rows; ++v) {
        for (int u = 0; u < picture.cols; ++u) {
          const cv::Vec3b bgr = picture.at<cv::Vec3b>(v, u);
          const PixelPosition at =
              pixel_from_angles(angles_from_direction(ray_of(viewport, u, v)), kPanorama);
          const Color exact = color_at(static_cast<int>(std::lround(at.u)) % kPanorama.width,
                                       static_cast<int>(std::lround(at.v)));
          worst = std::max({worst, std::abs(bgr[0] - exact.blue), std::abs(bgr[1] - exact.green),
                            std::abs(bgr[2] - exact.red)});
        }
      }
      EXPECT_LE(worst, 2) << method_name(method) << " yaw " << yaw_deg;
    }
  }
}

}  // namespace
}  // namespace raywalk
