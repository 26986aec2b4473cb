// The accuracy of views: against the true picture, with any distances, and with gains.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/room/room.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"
#include "core/view/view_plan.h"

namespace raywalk {
namespace {

// A pillar beyond the front right corner, which hides different parts of the walls from every
// viewpoint.
SyntheticRoomSpec room_with_pillar() {
  return {.scene = {.obstacle = SceneBox{{0.7, -1.2, 0.8}, {1.2, 0.3, 1.3}}},
          .overhang_m = 0.25,
          .width = 192};
}

// In the middle, anywhere, on a line, on a corner, and 1 nm inside a line.
const std::vector<PlanPoint> kQualityViewpoints = {{0.0, 0.0},  {0.23, 0.31},      {-0.31, 0.12},
                                                   {0.5, 0.1},  {0.3, -0.5},       {-0.5, 0.5},
                                                   {0.5, -0.5}, {-0.5 + 1e-9, 0.2}};

TEST(RendererQuality, CorrectedViewsMatchTheTruthWhereInitialOnesDoNot) {
  const TestRoom room({.overhang_m = 0.25, .height_m = 0.6, .width = 192});
  for (const PlanPoint at : kQualityViewpoints) {
    EXPECT_LT(room.psnr({.method = ViewMethod::kInitial}, at), 25.0);
    for (const ViewMethod method : kCorrected) {
      for (const double k_deg : {45.0, 76.0, 90.0}) {
        EXPECT_GT(room.psnr({.method = method, .k_deg = k_deg}, at), 45.0)
            << method_name(method) << " at " << at.x_m << ',' << at.z_m << ", k " << k_deg;
      }
    }
  }
}

TEST(RendererQuality, SoDoThoseOnTheBordersOfSeveralCells) {
  const TestRoom room({.cells_x = 2, .cells_z = 2, .overhang_m = 0.25, .width = 96});
  for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {1.0, 1.0}, {0.0, -0.7}, {0.3, -1e-9}}) {
    for (const ViewMethod method : kCorrected) {
      EXPECT_GT(room.psnr({.method = method, .k_deg = 76.0}, at), 35.0)
          << method_name(method) << " at " << at.x_m << ',' << at.z_m;
    }
  }
}

// A small room of cell side `scale` metres.
SyntheticRoomSpec scaled_room(double scale) {
  SyntheticRoomSpec spec = box_room(96);
  spec.side_m *= scale;
  spec.spacing_m *= scale;
  spec.overhang_m *= scale;
  spec.scene.walls.min_m *= scale;
  spec.scene.walls.max_m *= scale;
  spec.scene.texture_wavelength_m *= scale;
  return spec;
}

TEST(RendererQuality, CellsOfMicrometresAndKilometresRenderAsOneOfAMetreDoes) {
  for (const ViewMethod method : kCorrected) {
    const auto psnr = [&](double scale) {
      return TestRoom(scaled_room(scale)).psnr({.method = method}, {0.1 * scale, -0.2 * scale});
    };
    const double at_one_metre = psnr(1.0);
    EXPECT_GT(at_one_metre, 35.0);
    for (const double scale : {8e-6, 1e-3, 80.0, 1e3}) {
      EXPECT_NEAR(psnr(scale), at_one_metre, 0.1) << scale;
    }
    // In a room of fixed size a cell of micrometres sees it from one point.
    const TestRoom tiny({.side_m = 8e-6, .spacing_m = 1e-6, .width = 96});
    EXPECT_GT(tiny.psnr({.method = method}, {1.3e-6, -2.1e-6}), 45.0);
  }
}

TEST(RendererQuality, SparseAndSmallDistanceMapsSuffice) {
  // Whole fractions of the panoramas' size, another one, and larger ones.
  for (const int width : {96, 48, 64, 240}) {
    const TestRoom room(
        {.overhang_m = 0.25, .width = 192, .distance_every = 5, .distance_width = width});
    for (const ViewMethod method : kCorrected) {
      for (const PlanPoint at : kQualityViewpoints) {
        EXPECT_GT(room.psnr({.method = method}, at), 34.0)
            << width << " at " << at.x_m << ',' << at.z_m;
      }
    }
  }
}

TEST(RendererQuality, LinesWithoutDistancesUseThoseOfOtherLines) {
  const TestDirectory directory;
  const SyntheticRoomSpec spec = box_room();
  write_synthetic_room(spec, directory / "room.lf");
  for (const char* line : {"x1", "z0", "z1"}) remove_distances(directory / "room.lf", line);
  const Room room = Room::open(directory / "room.lf");
  for (const ViewMethod method : kCorrected) {
    Renderer renderer(room, {.method = method});
    const PlanPoint far_from_maps{0.3, 0.45};
    EXPECT_GT(psnr_db(renderer.render(far_from_maps).image,
                      render_truth(spec, far_from_maps, spec.width)),
              38.0);
  }
}

TEST(RendererQuality, OccludedViewsStayCloseToTheTruthAndTwoSidedOnesFillLess) {
  const TestRoom room(room_with_pillar());
  for (const PlanPoint at : kQualityViewpoints) {
    const RenderedView front = room.view({.method = ViewMethod::kHlfVd}, at);
    const RenderedView both = room.view({.method = ViewMethod::kTwoSided}, at);
    EXPECT_LE(both.report.filled_share, front.report.filled_share);
    for (const RenderedView* view : {&front, &both}) {
      EXPECT_GT(psnr_db(view->image, room.truth(at)), 40.0) << at.x_m << ',' << at.z_m;
    }
  }
  const auto filled = [&](ViewMethod method) {
    return room.view({.method = method}, {0.0, 0.0}).report.filled_share;
  };
  EXPECT_LT(filled(ViewMethod::kTwoSided), filled(ViewMethod::kHlfVd));
}

// A pixel of the output lies beside one of the distances, and is read from other stations than it.
TEST(RendererQuality, NothingIsLeftBlackWhereStationsSeeDifferentThings) {
  SyntheticRoomSpec spec = pillar_spec();
  spec.distance_every = 3;
  const TestRoom room(spec);
  for (const ViewMethod method : kCorrected) {
    for (const int stations : {1, 3}) {
      for (const int width : {100, 256}) {
        for (const PlanPoint at : {PlanPoint{0.1, -0.05}, {-0.35, -0.34}, {0.05, -0.39}}) {
          const cv::Mat view =
              room.image({.method = method, .width = width, .stations_mixed = stations}, at);
          cv::Mat black;
          cv::inRange(view, cv::Scalar::all(0), cv::Scalar::all(30), black);
          EXPECT_EQ(cv::countNonZero(black), 0)
              << method_name(method) << ' ' << stations << " of " << width << " px";
        }
      }
    }
  }
}

// Texture with a wavelength of a few pixels, whose crests linear interpolation flattens.
const SyntheticRoomSpec kTextured{
    .scene = {.texture_wavelength_m = 0.5}, .overhang_m = 0.25, .width = 192};

TEST(RendererInterpolation, CubicIsCloserToTheTruthThanLinear) {
  const TestRoom room(kTextured);
  for (const ViewMethod method : kCorrected) {
    for (const PlanPoint at : {PlanPoint{0.13, -0.21}, {-0.31, 0.17}}) {
      const ViewOptions linear{.method = method};
      const ViewOptions cubic{.method = method, .interpolation = Interpolation::kCubic};
      EXPECT_GT(room.psnr(cubic, at), room.psnr(linear, at) + 1.0) << method_name(method);
    }
  }
}

TEST(RendererInterpolation, InitialViewsAndFlatPicturesAreResampledWithIt) {
  SyntheticRoomSpec spec = kTextured;
  spec.scene.infinitely_far = true;
  const TestRoom room(spec);
  const ViewOptions linear{.method = ViewMethod::kInitial, .width = 300};
  ViewOptions cubic = linear;
  cubic.interpolation = Interpolation::kCubic;
  EXPECT_GT(room.psnr(cubic, {0.1, 0.2}), room.psnr(linear, {0.1, 0.2}) + 1.0);
  // At the captured width columns are copied either way.
  const ViewOptions copied{.method = ViewMethod::kInitial};
  cubic.width = 0;
  EXPECT_EQ(largest_difference(room.image(copied, {0.1, 0.2}), room.image(cubic, {0.1, 0.2})), 0.0);
  // Across the seam, over the zenith, and straight: parts of the panorama and all of it.
  for (const Viewport& viewport : {looking(170, 10, 20, 57, 70, 45), looking(0, 80, 0, 57, 70, 45),
                                   looking(0, 0, 0, 57, 70, 45)}) {
    const cv::Mat truth = true_picture(spec, {0.1, 0.2}, viewport);
    const auto psnr = [&](const ViewOptions& options) {
      Renderer renderer(room.room(), options);
      // Another picture first, so that leftovers in memory would show.
      renderer.render({0.1, 0.2}, looking(0, -57, 0, 90, 50, 50));
      return psnr_db(renderer.render({0.1, 0.2}, viewport).image, truth);
    };
    EXPECT_GT(psnr(cubic), psnr(copied) + 1.0);
  }
}

TEST(RendererStations, AnyNumberOfThemStaysCloseToTheTruth) {
  const TestRoom room(kTextured);
  const PlanPoint at{0.13, -0.21};
  for (const ViewMethod method : kCorrected) {
    const double one_db = room.psnr({.method = method}, at);
    EXPECT_GT(one_db, 30.0);
    for (const int stations : {2, 5, 16}) {
      EXPECT_NEAR(room.psnr({.method = method, .stations_mixed = stations}, at), one_db, 3.0)
          << method_name(method) << ' ' << stations;
    }
  }
}

// Every station off its line by up to a share of the cell, at random: across, and up or down.
std::function<OffLine(const std::string&, int)> scattered(double across, double up) {
  return [=](const std::string& line, int station) {
    std::seed_seq seed{static_cast<int>(line[0]), static_cast<int>(line[1]), station};
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const double across_share = share(random);
    return OffLine{across * across_share, up * share(random)};
  };
}

// A room of cell side 1 m whose stations are off their lines.
SyntheticRoomSpec uneven_room(double across_m, double up_m) {
  SyntheticRoomSpec spec = room_with_pillar();
  spec.off_line = scattered(across_m, up_m);
  return spec;
}

// Enough that the mean does not depend on how single silhouettes meet the pixels.
const std::vector<PlanPoint> kUnevenViewpoints = {{0.0, 0.0},    {0.23, 0.31},  {-0.31, 0.12},
                                                  {-0.2, -0.35}, {0.12, -0.18}, {0.37, -0.07}};

// Against the truth at the height of the views, which is that of the stations around.
double mean_psnr(const TestRoom& room, ViewMethod method) {
  Renderer renderer(room.room(), {.method = method});
  double sum_db = 0.0;
  for (const PlanPoint at : kUnevenViewpoints) {
    SyntheticRoomSpec there = room.spec();
    there.height_m = ViewPlan(room.room().grid(), at, {kHalfPi, 0.0}).height_m();
    sum_db += psnr_db(renderer.render(at).image, render_truth(there, at, there.width));
  }
  return sum_db / static_cast<double>(kUnevenViewpoints.size());
}

TEST(RendererOffLine, ViewsAreAsGoodAsFromStationsOnTheLines) {
  const TestRoom on_line(uneven_room(0.0, 0.0)), beside(uneven_room(0.1, 0.0)),
      above(uneven_room(0.0, 0.1)), far_off(uneven_room(0.2, 0.2));
  for (const ViewMethod method : kCorrected) {
    const double on_line_db = mean_psnr(on_line, method);
    EXPECT_GT(on_line_db, 41.0);
    EXPECT_GT(mean_psnr(beside, method), on_line_db - 0.7);
    EXPECT_GT(mean_psnr(above, method), on_line_db - 0.7);
    EXPECT_GT(mean_psnr(far_off, method), on_line_db - 3.0);
  }
}

constexpr int kRoomWidth = 256;

// A room of few stations. Of its distances half are right, the others anything; none are confident.
SyntheticRoomSpec room_of_poor_distances(int cells_z) {
  SyntheticRoomSpec spec = box_room(kRoomWidth);
  spec.cells_z = cells_z;
  spec.spacing_m = 0.25;
  spec.stored_distance = [](int u, int v, double exact_m) {
    std::minstd_rand random(static_cast<unsigned>(1 + 613 * u + v));
    random.discard(3);
    if (random() % 2 == 0) return static_cast<float>(exact_m);
    return static_cast<float>(std::uniform_real_distribution<double>(0.2, 8.0)(random));
  };
  spec.stored_confidence = [](int u, int v) {
    return static_cast<std::uint8_t>((7 * u + 3 * v) % 5 == 0 ? 0 : 72);
  };
  return spec;
}

// The frames of the two stations nearest to a viewpoint, by nearness.
cv::Mat cross_fade(const TestRoom& room, PlanPoint at) {
  std::vector<std::pair<double, PlanPoint>> stations;
  for (const Line& line : room.room().grid().lines) {
    for (const Station& station : line.stations) {
      const PlanPoint p{station.position_m.x(), station.position_m.z()};
      stations.emplace_back(std::hypot(p.x_m - at.x_m, p.z_m - at.z_m), p);
    }
  }
  std::ranges::sort(stations, {}, &std::pair<double, PlanPoint>::first);
  const auto& [near_m, near] = stations[0];
  const auto& [far_m, far] = stations[1];
  const double share = far_m / (near_m + far_m);
  cv::Mat mixed;
  cv::addWeighted(room.truth(near), share, room.truth(far), 1.0 - share, 0.0, mixed);
  return mixed;
}

TEST(PoorDistances, NoViewIsWorseThanCrossFadingTheNearestStations) {
  for (const int cells_z : {0, 1}) {
    const TestRoom room(room_of_poor_distances(cells_z));
    const auto places = cells_z == 0
                            ? std::vector<PlanPoint>{{0.1, 0.02}, {-0.3, -0.04}, {0.37, 0.0}}
                            : std::vector<PlanPoint>{{0.1, 0.2}, {-0.3, 0.45}, {0.4, -0.1}};
    for (const PlanPoint at : places) {
      const cv::Mat truth = room.truth(at);
      EXPECT_GT(room.psnr({.method = ViewMethod::kTwoSided}, at),
                psnr_db(cross_fade(room, at), truth))
          << cells_z << " cells, at " << at.x_m << ',' << at.z_m;
    }
  }
}

// Poor distances of one half of the directions do not spoil the other: there the view is the same
// as from exact maps. They are too far, as nearer ones would hide what is right.
TEST(PoorDistances, DoNotSpoilWhatIsConfident) {
  SyntheticRoomSpec spec = box_room(kRoomWidth);
  spec.spacing_m = 0.25;
  const auto is_good = [](int u) { return u < kRoomWidth / 2; };
  spec.stored_distance = [=](int u, int, double exact_m) {
    return static_cast<float>(is_good(u) ? exact_m : 1.5 * exact_m);
  };
  spec.stored_confidence = [=](int u, int) {
    return static_cast<std::uint8_t>(is_good(u) ? 255 : 72);
  };
  const TestRoom room(spec);
  spec.stored_distance = {};
  spec.stored_confidence = {};
  const TestRoom exact(spec);
  const PlanPoint at{0.02, -0.03};
  const ViewOptions options{.method = ViewMethod::kTwoSided};
  // Away from the border between them.
  const cv::Range good(kRoomWidth / 8, 3 * kRoomWidth / 8);
  EXPECT_GT(psnr_db(room.image(options, at).colRange(good).clone(),
                    exact.image(options, at).colRange(good).clone()),
            45.0);
}

// Extreme contents of distance maps, by name.
std::map<std::string, std::function<float(int, int, double)>> extreme_distances() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto always = [](float metres) { return [metres](int, int, double) { return metres; }; };
  const auto checkerboard = [](float a, float b) {
    return [a, b](int u, int v, double) { return (u / 2 + v / 2) % 2 == 0 ? a : b; };
  };
  return {{"1 um", always(1e-6f)},
          {"100000 km", always(1e8f)},
          {"none", always(0.0f)},
          {"infinite", always(kInfinity)},
          {"less than a float can invert", always(1e-42f)},
          {"the largest float", always(std::numeric_limits<float>::max())},
          {"half a metre, where stations are", always(0.5f)},
          {"near beside far", checkerboard(1e-6f, 1e8f)},
          {"known beside unknown", checkerboard(2.0f, 0.0f)},
          {"infinite beside zero", checkerboard(kInfinity, 0.0f)}};
}

// The least and the largest level of a picture's channels.
cv::Point2d levels_of(const cv::Mat& picture) {
  double least = 0.0;
  double most = 0.0;
  cv::minMaxLoc(picture.reshape(1), &least, &most);
  return {least, most};
}

// For any distance maps a view consists of captured colours: no level outside their range, no
// missing pixel, the same picture every time; whatever is mixed and how it is read.
TEST(RendererExtremes, WrongDistancesNeverGiveInvalidPictures) {
  const cv::Point2d captured{38.0, 218.0};  // range of the walls' levels
  for (const auto& [name, stored] : extreme_distances()) {
    const TestRoom room(
        {.overhang_m = 0.25, .width = 64, .distance_width = 48, .stored_distance = stored});
    for (const ViewMethod method : kCorrected) {
      for (const int stations : {1, 3, 16}) {
        for (const int width : {0, 20, 100}) {
          const ViewOptions options{.method = method, .width = width, .stations_mixed = stations};
          for (const PlanPoint at : {PlanPoint{0.1, 0.2}, {0.5, -0.5}, {-0.5, 0.0}}) {
            const RenderedView view = room.view(options, at);
            const cv::Point2d levels = levels_of(view.image);
            EXPECT_GE(levels.x, captured.x - 1.0) << name;
            EXPECT_LE(levels.y, captured.y + 1.0) << name;
            EXPECT_EQ(view.report.empty_share, 0.0) << name;
            EXPECT_LE(view.report.filled_share + view.report.unseen_share, 1.0) << name;
          }
        }
        ViewOptions cubic{
            .method = method, .interpolation = Interpolation::kCubic, .stations_mixed = stations};
        EXPECT_EQ(largest_difference(room.image(cubic, {0.1, 0.2}), room.image(cubic, {0.1, 0.2})),
                  0.0)
            << name;
      }
    }
  }
}

// Without parallax there is nothing to correct, whichever way the maps say so. Where nothing is
// known the two neighbours are mixed, as in an initial view.
TEST(RendererExtremes, UnknownEverywhereIsInfinitelyFar) {
  const auto view_of = [](float stored, ViewMethod method) {
    return TestRoom({.overhang_m = 0.25,
                     .width = 96,
                     .stored_distance = [stored](int, int, double) { return stored; }})
        .image({.method = method}, {0.13, -0.21});
  };
  for (const ViewMethod method : kCorrected) {
    const cv::Mat infinite = view_of(std::numeric_limits<float>::infinity(), method);
    EXPECT_LE(largest_difference(view_of(1e8f, method), infinite), 1.0);
  }
  EXPECT_LE(
      largest_difference(view_of(0.0f, ViewMethod::kHlfVd), view_of(0.0f, ViewMethod::kInitial)),
      1.0);
}

// Linear between the middles of the patches, around the seam, and constant beyond them at a pole.
double gain_at(const cv::Mat& local, double u, double v, PanoramaSize size) {
  const double x = (u + 0.5) / size.width * local.rows - 0.5;
  const double y = std::clamp((v + 0.5) / size.height * local.cols - 0.5, 0.0, local.cols - 1.0);
  double sum = 0.0;
  for (const int right : {0, 1}) {
    for (const int lower : {0, 1}) {
      const auto column = static_cast<int>(std::floor(x)) + right;
      const auto row = std::min(static_cast<int>(y) + lower, local.cols - 1);
      const double across = x - std::floor(x), down = y - std::floor(y);
      sum += (right == 1 ? across : 1 - across) * (lower == 1 ? down : 1 - down) *
             local.at<cv::Vec3f>((column + 2 * local.rows) % local.rows, row)[0];
    }
  }
  return sum;
}

// All lines with another exposure, and gains that undo it: the room but for rounded positions.
TEST(Exposure, GainsUndoWhatLinesWereExposedBy) {
  SyntheticRoomSpec spec = box_room(96);
  const TestRoom plain(spec);
  spec.line_gain = {{"x0", 0.8}, {"x1", 1.1}, {"z0", 0.7}, {"z1", 0.95}};
  const RoomWithGains room(spec, [](int line, int) {
    const float exposed = std::array{0.8f, 1.1f, 0.7f, 0.95f}[static_cast<std::size_t>(line)];
    return GainField{.whole = ColourGain::all(1.0f / exposed)};
  });
  for (const ViewMethod method : kViewMethods) {
    for (const bool gains : {true, false}) {
      const ViewOptions options{.method = method, .gains = gains};
      const cv::Mat view = Renderer(room.room(), options).render(PlanPoint{0.1, -0.2}).image;
      const cv::Mat expected = plain.image(options, {0.1, -0.2});
      cv::Mat difference;
      cv::absdiff(view, expected, difference);
      const int differ = cv::countNonZero(difference.reshape(1) > 4);
      EXPECT_EQ(differ <= 3, gains) << method_name(method) << ": " << differ;
    }
  }
}

// A grey sky shows the gains themselves, also across the seam of the panoramas.
TEST(Exposure, ViewsOfASkyShowTheGainsOfEveryDirection) {
  SyntheticRoomSpec spec = box_room(96);
  spec.scene.contrast = 0.0;
  spec.scene.infinitely_far = true;
  GainField field;
  field.local.create(48, 24, CV_32FC3);
  for (int theta = 0; theta < 48; ++theta) {
    for (int phi = 0; phi < 24; ++phi) {
      field.local.at<cv::Vec3f>(theta, phi) = cv::Vec3f::all(
          static_cast<float>(0.7 + 0.2 * std::cos((theta + 0.5) / 48 * kTwoPi) + 0.015 * phi));
    }
  }
  const RoomWithGains room(spec, [&](int, int) { return field; });
  for (const ViewMethod method : kViewMethods) {
    const cv::Mat view =
        Renderer(room.room(), {.method = method}).render(PlanPoint{0.3, 0.31}).image;
    for (int u = 0; u < view.cols; ++u) {
      for (int v = 4; v < view.rows - 4; ++v) {  // not beside a pole, where they are constant
        ASSERT_NEAR(view.at<cv::Vec3b>(v, u)[1], 128.0 * gain_at(field.local, u, v, {96, 48}), 1.0)
            << method_name(method) << ' ' << u << ", " << v;
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
