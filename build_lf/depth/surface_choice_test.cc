#include "build_lf/depth/surface_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/tile_planes.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kChosenSize{256, 128};
constexpr double kChosenPixel_per_m = kTwoPi / (0.5 * kChosenSize.width);

// A room with a box in the middle of a wall's view, captured from a line in front of it.
SyntheticRoomSpec room_with_box() {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.width = kChosenSize.width;
  spec.scene.obstacle = SceneBox{{-0.15, -0.3, 0.5}, {0.15, 0.3, 0.7}};
  return spec;
}

class SurfaceChoiceTest : public testing::Test {
 protected:
  // The photographs, with so much of their contrast, and noise.
  explicit SurfaceChoiceTest(double contrast = 1.0, double noise_levels = 0.0)
      : room_(spec_, [=](StationIndex station, cv::Mat* frame) {
          frame->convertTo(*frame, -1, contrast, 110.0 * (1.0 - contrast));
          if (noise_levels > 0.0) add_noise(station, noise_levels, frame);
        }) {
    for (int i = 0; i < count(); ++i) {
      colours_.push_back(station_colours(room_.room(), {0, i}, kChosenSize, {}));
      truth_.push_back(true_map(spec_.scene, position_m(i), kChosenSize));
      swept_.push_back(fattened(truth_.back()));
      ranges_.push_back(sampled_ranges(colours_.back(), {}));
    }
  }

  int count() const { return static_cast<int>(room_.grid().lines[0].stations.size()); }
  Eigen::Vector3d position_m(int i) const {
    return room_.grid().lines[0].stations[static_cast<size_t>(i)].position_m;
  }

  // What is near, spread by 3 pixels, as by windows.
  static InverseDistanceMap fattened(InverseDistanceMap map) {
    cv::Mat inverse(map.size.width, map.size.height, CV_32F, map.inverse.data());
    cv::Mat spread;
    cv::dilate(inverse, spread, cv::Mat::ones(7, 7, CV_8U));
    spread.copyTo(inverse);
    return map;
  }

  // 255 where the swept map shows the box, CV_8UC1, [theta][phi].
  cv::Mat box_of(int i) const {
    const InverseDistanceMap without =
        true_map(line_of_scale(1.0).scene, position_m(i), kChosenSize);
    cv::Mat box(kChosenSize.width, kChosenSize.height, CV_8UC1, cv::Scalar(0));
    for (size_t pixel = 0; pixel < without.inverse.size(); ++pixel) {
      if (swept_[static_cast<size_t>(i)].inverse[pixel] > without.inverse[pixel] + 0.1f) {
        box.data[pixel] = 255;
      }
    }
    return box;
  }

  std::vector<ChoiceView> views_except(int own) const {
    std::vector<ChoiceView> views;
    for (int i = 0; i < count(); ++i) {
      const cv::Mat& ranges = ranges_[static_cast<size_t>(i)];
      if (i == own) continue;
      views.push_back(
          {{ranges.ptr<ColourRange>(), ranges.total()}, &swept_[static_cast<size_t>(i)]});
    }
    return views;
  }

  InverseDistanceMap chosen(int own) const {
    return choose_surfaces(swept_[static_cast<size_t>(own)], colours_[static_cast<size_t>(own)],
                           views_except(own), kChosenPixel_per_m);
  }

  // The share of what windows made wrong, or of the rest, that is right.
  double right(const InverseDistanceMap& map, int own, bool made_wrong) const {
    const InverseDistanceMap& truth = truth_[static_cast<size_t>(own)];
    const InverseDistanceMap& swept = swept_[static_cast<size_t>(own)];
    return share_within(map, truth, 1.5 * kChosenPixel_per_m, [&](size_t pixel) {
      const bool wrong = swept.inverse[pixel] - truth.inverse[pixel] > 1.5 * kChosenPixel_per_m;
      return wrong == made_wrong;
    });
  }

  SyntheticRoomSpec spec_ = room_with_box();
  DepthTestRoom room_;
  std::vector<StationColours> colours_;
  std::vector<InverseDistanceMap> truth_, swept_;
  std::vector<cv::Mat> ranges_;
};

TEST_F(SurfaceChoiceTest, ASurfaceEndsWhereItsColoursDo) {
  const int middle = count() / 2;
  const InverseDistanceMap map = chosen(middle);
  EXPECT_GT(right(map, middle, true), 0.8);
  EXPECT_GT(right(map, middle, false), 0.99);
  EXPECT_EQ(map.confidence, swept_[static_cast<size_t>(middle)].confidence);
}

class SurfaceChoiceInNoiseTest : public SurfaceChoiceTest {
 protected:
  SurfaceChoiceInNoiseTest() : SurfaceChoiceTest(1.0, 20.0) {}
};

// All that is seen differs by more than what counts as hidden in clean pictures.
TEST_F(SurfaceChoiceInNoiseTest, NoiseDoesNotMakeHiddenSurfacesLikely) {
  EXPECT_GT(right(chosen(count() / 2), count() / 2, false), 0.97);
}

// Where colours differ little, what is hidden weighs more.
class SurfaceChoiceInDuskTest : public SurfaceChoiceTest {
 protected:
  SurfaceChoiceInDuskTest() : SurfaceChoiceTest(0.12) {}
};

TEST_F(SurfaceChoiceInDuskTest, ASurfaceEndsWhereItsColoursDo) {
  EXPECT_GT(right(chosen(count() / 2), count() / 2, true), 0.9);
}

// Two of three views mask the box, and a little around it: they do not speak against it.
TEST_F(SurfaceChoiceInDuskTest, MaskedPixelsSayNothing) {
  for (int i = 0; i < count(); ++i) {
    if (i % 3 == 0) continue;
    cv::Mat valid = 255 - box_of(i);
    ranges_[static_cast<size_t>(i)] = sampled_ranges(colours_[static_cast<size_t>(i)], valid);
  }
  const InverseDistanceMap map = chosen(count() / 2);
  EXPECT_GT(right(map, count() / 2, true), 0.8);
  EXPECT_GT(right(map, count() / 2, false), 0.99);
}

// As on gloss, every view shows the box in other colours: nearly all say that what would be behind
// it is hidden.
TEST_F(SurfaceChoiceTest, GlossIsNoHole) {
  for (int i = 0; i < count(); ++i) {
    const auto at = static_cast<size_t>(i);
    StationColours shiny = colours_[at];
    shiny.least = shiny.least.clone();
    cv::add(shiny.least, cv::Scalar::all(i % 2 == 0 ? 7 : -7), shiny.least, box_of(i));
    shiny.most = shiny.least;
    ranges_[at] = sampled_ranges(shiny, {});
  }
  const InverseDistanceMap map = chosen(count() / 2);
  EXPECT_GT(right(map, count() / 2, true), 0.9);
  EXPECT_GT(right(map, count() / 2, false), 0.993);
}

TEST_F(SurfaceChoiceTest, UnknownPixelsAndLonelyMapsStayAsTheyAre) {
  const int middle = count() / 2;
  InverseDistanceMap& swept = swept_[static_cast<size_t>(middle)];
  EXPECT_EQ(choose_surfaces(swept, colours_[static_cast<size_t>(middle)],
                            std::vector{views_except(middle)[0]}, kChosenPixel_per_m)
                .inverse,
            swept.inverse);
  for (size_t pixel = 0; pixel < swept.inverse.size(); pixel += 3) {
    swept.confidence[pixel] = 0;
    swept.inverse[pixel] = 7.0f;
  }
  const InverseDistanceMap map = chosen(middle);
  for (size_t pixel = 0; pixel < swept.inverse.size(); pixel += 3)
    EXPECT_EQ(map.inverse[pixel], 7.0f);
}

Eigen::Vector3d direction_of(int theta, int phi, PanoramaSize size) {
  return direction_from_angles(angles_from_pixel({double(theta), double(phi)}, size));
}

// A floor 1.5 m below, everything else infinitely far; as a plane it goes on above the horizon.
double floor_inverse(const Eigen::Vector3d& direction) { return -direction.y() / 1.5; }

// How far the nearest of a tile's planes is from the floor, at most, over the tile.
double largest_error(const TilePlanes& planes, int column, int row, PanoramaSize size) {
  double least = 1e9;
  for (const Plane& plane : planes.around(column, row, 9)) {
    double largest = 0.0;
    for (int i = 0; i < kPlaneTile * kPlaneTile; ++i) {
      const Eigen::Vector3d direction = direction_of(column * kPlaneTile + i / kPlaneTile,
                                                     row * kPlaneTile + i % kPlaneTile, size);
      const double inverse = plane.cast<double>().dot(direction);
      largest = std::max(largest, std::fabs(inverse - floor_inverse(direction)));
    }
    least = std::min(least, largest);
  }
  return least;
}

// Poles, the seam, and heights that are no multiple of a tile.
TEST(TilePlanesTest, CoverTheWholeSphereAtAnySize) {
  for (const PanoramaSize size : {PanoramaSize{32, 16}, {36, 18}, {256, 128}, {1024, 512}}) {
    InverseDistanceMap map{{}, {0, 0, 0}, size, {}, {}};
    for (int theta = 0; theta < size.width; ++theta) {
      for (int phi = 0; phi < size.height; ++phi) {
        const double inverse = floor_inverse(direction_of(theta, phi, size));
        map.inverse.push_back(static_cast<float>(std::max(0.0, inverse)));
      }
    }
    map.confidence.assign(map.inverse.size(), 255);
    const TilePlanes planes(map, 8.0 / size.width);
    EXPECT_EQ(planes.columns() * kPlaneTile, size.width);
    EXPECT_GE(planes.rows() * kPlaneTile, size.height);
    const int lowest = size.height / kPlaneTile - 1;
    for (const int column : {0, planes.columns() / 2, planes.columns() - 1}) {
      for (const int row : {lowest, lowest - 1}) {
        EXPECT_LT(largest_error(planes, column, row, size), 4.0 / size.width)
            << size.width << ' ' << column << ' ' << row;
      }
      for (int row = 0; row < planes.rows(); ++row) {
        for (const Plane& plane : planes.around(column, row, 9)) EXPECT_TRUE(plane.allFinite());
      }
    }
    map.confidence.assign(map.inverse.size(), 0);
    EXPECT_TRUE(TilePlanes(map, 8.0 / size.width).around(0, lowest, 9).empty()) << "not known";
  }
}

}  // namespace
}  // namespace raywalk::build_lf
