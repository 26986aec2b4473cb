// Distances from frames with masks: objects that move with the camera get no distances and do not
// disturb others; surfaces they hide are filled in from other stations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/estimate_depth.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/quality/frame_checks.h"
#include "core/base/error.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;

constexpr double kConeDeg = 22.0;

bool in_cone(int u, int v, PanoramaSize size, double cone_deg) {
  const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
  return angles.phi_rad < radians_from_degrees(cone_deg - 90.0);
}

// A dolly with a pattern, the same in every frame.
void paint_dolly(StationIndex, cv::Mat* frame) {
  const PanoramaSize size{frame->cols, frame->rows};
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      if (!in_cone(u, v, size, kConeDeg)) continue;
      const bool light = (u / 5 + v / 3) % 2 == 0;
      frame->at<cv::Vec3b>(v, u) = light ? cv::Vec3b(240, 20, 230) : cv::Vec3b(20, 90, 30);
    }
  }
}

DepthTestRoom::Mask cone_mask(PanoramaSize size, double cone_deg = kConeDeg) {
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(255));
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      if (in_cone(u, v, size, cone_deg)) mask.at<uchar>(v, u) = 0;
    }
  }
  return [mask](StationIndex) { return mask; };
}

PanoramaSize size_of(const SyntheticRoomSpec& spec) { return {spec.width, spec.width / 2}; }

TEST(StationValidity, HasAMarginAroundMaskedPixels) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const auto mask = [](StationIndex) {
    cv::Mat valid(64, 128, CV_8UC1, cv::Scalar(255));
    valid(cv::Rect(0, 60, 128, 4)).setTo(0);  // the nadir
    valid(cv::Rect(0, 20, 2, 44)).setTo(0);   // beside the seam
    return valid;
  };
  const DepthTestRoom room(spec, nullptr, mask);
  const cv::Mat whole = station_validity(room.room(), {0, 1}, {128, 64}, 2);
  ASSERT_EQ(whole.size(), cv::Size(64, 128));
  EXPECT_EQ(whole.at<uchar>(64, 57), 255);
  EXPECT_EQ(whole.at<uchar>(64, 58), 0);
  EXPECT_EQ(whole.at<uchar>(3, 40), 0);
  EXPECT_EQ(whole.at<uchar>(4, 40), 255);
  EXPECT_EQ(whole.at<uchar>(126, 40), 0);  // across the seam
  EXPECT_EQ(whole.at<uchar>(125, 40), 255);
  // A reduced pixel is invalid if one of its four pixels is.
  const cv::Mat reduced = station_validity(room.room(), {0, 1}, {64, 32}, 0);
  EXPECT_EQ(reduced.at<uchar>(0, 12), 0);
  EXPECT_EQ(reduced.at<uchar>(1, 12), 255);
  EXPECT_TRUE(station_validity(DepthTestRoom(spec).room(), {0, 1}, {64, 32}, 0).empty());
}

// Accuracy of a room's final maps in the region that the dolly hides.
double share_within_a_pixel_below(const SyntheticRoomSpec& spec, const Room& room) {
  const Room estimated = Room::open(room.directory());
  double sum = 0.0;
  int maps = 0;
  for (int l = 0; l < static_cast<int>(room.grid().lines.size()); ++l) {
    const DistanceVolume& volume = estimated.distances(l);
    const PanoramaSize size = volume.size();
    for (int m = 0; m < volume.maps(); ++m) {
      const StationDistances stored = stored_distances(volume, m);
      const StationIndex station{l, volume.stations()[static_cast<size_t>(m)]};
      InverseDistanceMap map{station, room.grid().station(station).position_m, size, {}, {}};
      for (size_t pixel = 0; pixel < stored.distance_m.size(); ++pixel) {
        const bool known = stored.confidence[pixel] >= kMinConfidence;
        map.omega.push_back(known ? 1.0f / stored.distance_m[pixel] : 1e6f);
      }
      // A pixel of parallax at the reach, half the cell's side.
      const double pixel_per_m = kTwoPi / size.width / (0.5 * spec.side_m);
      sum += share_within(
          map, true_map(spec.scene, map.position_m, size), pixel_per_m, [&](size_t pixel) {
            return in_cone(0, static_cast<int>(pixel) % size.height, size, kConeDeg);
          });
      ++maps;
    }
  }
  return sum / maps;
}

TEST(DepthMasks, FloorBelowComesFromOtherStations) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 96;
  spec.spacing_m = 0.125;
  spec.scene.texture_wavelength_m = 0.5;
  spec.overhang_m = 0.25;
  DepthOptions options;
  options.every = 2;
  const DepthTestRoom painted(spec, paint_dolly);
  options.room = painted.room().directory();
  estimate_depth(options);
  const DepthTestRoom masked(spec, paint_dolly, cone_mask(size_of(spec)));
  options.room = masked.room().directory();
  const DepthSummary summary = estimate_depth(options);
  EXPECT_TRUE(summary.frame_findings.empty());
  EXPECT_LT(share_within_a_pixel_below(spec, painted.room()), 0.5);
  EXPECT_GT(share_within_a_pixel_below(spec, masked.room()), 0.95);
}

TEST(DepthMasks, MovingObjectsOnTheRigDoNotHideMotion) {
  // 60 degrees of dolly: a quarter of every frame never changes.
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const auto change = [&](const DepthTestRoom& room) {
    return measure_links(room.room(), pairs_to_compare(room.grid())).front().compared.change;
  };
  const auto paint = [](StationIndex, cv::Mat* frame) {
    frame->rowRange(frame->rows * 2 / 3, frame->rows).setTo(cv::Scalar(120, 30, 200));
  };
  const auto mask = [&](StationIndex) {
    cv::Mat valid(spec.width / 2, spec.width, CV_8UC1, cv::Scalar(255));
    valid.rowRange(valid.rows * 2 / 3, valid.rows).setTo(0);
    return valid;
  };
  const double clean = change(DepthTestRoom(spec, nullptr, mask));
  EXPECT_LT(change(DepthTestRoom(spec, paint)), 0.95 * clean);
  EXPECT_NEAR(change(DepthTestRoom(spec, paint, mask)), clean, 1e-3 * clean);
}

TEST(DepthMasks, FlowWithMasksIsRejected) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const DepthTestRoom room(spec, nullptr, cone_mask(size_of(spec)));
  DepthOptions options;
  options.room = room.room().directory();
  options.method = DepthMethod::kFlow;
  EXPECT_THAT([&] { estimate_depth(options); },
              ::testing::ThrowsMessage<UsageError>(HasSubstr("--method sweep")));
  EXPECT_FALSE(std::filesystem::exists(options.room / "distances.partial"));
}

TEST(DepthMasks, FullyMaskedRoomGetsUnknownMaps) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const DepthTestRoom room(spec, nullptr, cone_mask(size_of(spec), 180.0));
  DepthOptions options;
  options.room = room.room().directory();
  options.every = 8;
  for (const MapSummary& map : estimate_depth(options).maps) {
    EXPECT_EQ(map.mean_confidence, 0.0);
  }
}

}  // namespace
}  // namespace raywalk::build_lf
