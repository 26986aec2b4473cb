#include "build_lf/depth/estimate_depth.h"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/quality/frame_checks.h"
#include "core/files/file_lock.h"
#include "core/files/test_support.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// Distances from frames with masks: objects that move with the camera get no distances and do not
// disturb others; surfaces they hide are filled in from other stations.
constexpr double kConeDeg = 22.0;

bool in_cone(int u, int v, PanoramaSize size, double cone_deg) {
  const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
  return angles.phi_rad < radians_from_degrees(cone_deg - 90.0);
}

// A dolly with a pattern, the same in every frame.
void paint_dolly(StationIndex, cv::Mat* frame) {
  const PanoramaSize size{frame->cols, frame->rows};
  for (const auto [u, v] : pixels_of(size)) {
    if (!in_cone(u, v, size, kConeDeg)) continue;
    const bool light = (u / 5 + v / 3) % 2 == 0;
    frame->at<cv::Vec3b>(v, u) = light ? cv::Vec3b(240, 20, 230) : cv::Vec3b(20, 90, 30);
  }
}

DepthTestRoom::Mask cone_mask(PanoramaSize size, double cone_deg = kConeDeg) {
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(255));
  for (const auto [u, v] : pixels_of(size)) {
    if (in_cone(u, v, size, cone_deg)) mask.at<uchar>(v, u) = 0;
  }
  return [mask](StationIndex) { return mask; };
}

PanoramaSize size_of(const SyntheticRoomSpec& spec) { return {spec.width, spec.width / 2}; }

TEST(StationValidity, HasAMarginAroundMaskedPixels) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const auto mask = [](StationIndex) {
    cv::Mat valid(64, 128, CV_8UC1, cv::Scalar(255));
    valid(cv::Rect(0, 60, 128, 4)).setTo(0);  // the nadir
    valid(cv::Rect(0, 20, 3, 44)).setTo(0);   // beside the seam
    return valid;
  };
  const DepthTestRoom room(spec, nullptr, mask);
  const cv::Mat whole = station_validity(room.room(), {0, 1}, {128, 64}, 2);
  ASSERT_EQ(whole.size(), cv::Size(64, 128));
  EXPECT_EQ(whole.at<uchar>(64, 57), 255);
  EXPECT_EQ(whole.at<uchar>(64, 58), 0);
  EXPECT_EQ(whole.at<uchar>(4, 40), 0);
  EXPECT_EQ(whole.at<uchar>(5, 40), 255);
  EXPECT_EQ(whole.at<uchar>(126, 40), 0);  // across the seam
  EXPECT_EQ(whole.at<uchar>(125, 40), 255);
  // A reduced pixel is invalid if one of its four pixels is.
  const cv::Mat reduced = station_validity(room.room(), {0, 1}, {64, 32}, 0);
  EXPECT_EQ(reduced.at<uchar>(1, 12), 0);
  EXPECT_EQ(reduced.at<uchar>(2, 12), 255);
  EXPECT_TRUE(station_validity(DepthTestRoom(spec).room(), {0, 1}, {64, 32}, 0).empty());
}

// Accuracy of a room's final maps in the region that the dolly hides.
double share_within_a_pixel_below(const SyntheticRoomSpec& spec, const Room& room) {
  const Room estimated = Room::open(room.directory());
  double sum = 0.0;
  int maps = 0;
  for (int line = 0; line < 4; ++line) {
    const DistanceVolume& volume = estimated.distances(line);
    const PanoramaSize size = volume.size();
    for (int m = 0; m < volume.maps(); ++m, ++maps) {
      const StationDistances stored = stored_distances(volume, m);
      const StationIndex station{line, volume.stations()[m]};
      InverseDistanceMap map{station, room.grid().station(station).position_m, size, {}, {}};
      for (size_t pixel = 0; pixel < stored.distance_m.size(); ++pixel) {
        const bool known = stored.confidence[pixel] >= kMinConfidence;
        map.inverse.push_back(known ? 1.0f / stored.distance_m[pixel] : 1e6f);
      }
      // A pixel of parallax at the reach, half the cell's side.
      const double pixel_per_m = kTwoPi / size.width / (0.5 * spec.side_m);
      const auto is_below = [&](int pixel) {
        return in_cone(0, pixel % size.height, size, kConeDeg);
      };
      sum += share_within(map, true_map(spec.scene, map.position_m, size), pixel_per_m, is_below);
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
  const DepthTestRoom painted(spec, paint_dolly);
  estimate_depth({.room = painted.room().directory(), .every = 2});
  const DepthTestRoom masked(spec, paint_dolly, cone_mask(size_of(spec)));
  const DepthSummary summary = estimate_depth({.room = masked.room().directory(), .every = 2});
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

TEST(DepthMasks, FullyMaskedRoomGetsUnknownMaps) {
  const SyntheticRoomSpec spec = line_of_scale(1.0);
  const DepthTestRoom room(spec, nullptr, cone_mask(size_of(spec), 180.0));
  const DepthSummary summary = estimate_depth({.room = room.room().directory(), .every = 8});
  for (const MapSummary& map : summary.maps) EXPECT_EQ(map.mean_confidence, 0.0);
}

// A room with exposures that differ and a person, so that every step finds something.
SyntheticRoomSpec parts_spec() {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 96;
  spec.spacing_m = 0.125;
  return spec;
}

void disturb(StationIndex station, cv::Mat* frame) {
  if (station.station % 4 == 1) frame->convertTo(*frame, -1, 0.7);
  if (station == StationIndex{1, 4}) {
    (*frame)(cv::Rect(24, 12, 12, 18)) = cv::Scalar(20, 30, 240);
  }
}

// Two copies of a room: one for a single run, one for parts.
class DepthPartsTest : public ::testing::Test {
 protected:
  explicit DepthPartsTest(const SyntheticRoomSpec& spec = parts_spec()) : room_(spec, disturb) {
    fs::copy(room_.room().directory(), parts_, fs::copy_options::recursive);
  }

  // The parts of all steps, the last part first, and one of them twice.
  static void make_all(const DepthOptions& options) {
    estimate_step(options, DepthStep::kPrepare, {});
    for (const DepthStep step : kDepthSteps) {
      if (step == DepthStep::kPrepare) continue;
      for (const int index : {3, 1, 1, 2}) estimate_step(options, step, {index, 3});
    }
  }

  void expect_same_as_one_run(DepthOptions options) {
    options.room = room_.room().directory();
    const DepthSummary plain = estimate_depth(options);
    options.room = parts_;
    make_all(options);
    const DepthSummary finished = estimate_depth(options);
    EXPECT_EQ(result_files_of(parts_), result_files_of(room_.room().directory()));
    EXPECT_EQ(finished.maps.size(), plain.maps.size());
    EXPECT_FALSE(fs::exists(parts_ / "distances.partial"));
  }

  DepthTestRoom room_;
  TestDirectory directory_;
  fs::path parts_ = directory_ / "parts.lf";
};

TEST_F(DepthPartsTest, GiveTheRoomOfOneRun) {
  expect_same_as_one_run({.every = 3});
  const Room room = Room::open(parts_);
  EXPECT_TRUE(room.manifest().gains) << "the exposures differ";
  EXPECT_TRUE(room.distances(1).left_out().any(4)) << "the person";
}

TEST_F(DepthPartsTest, GiveTheMapsOfOneRunByFlowAndWithStationsHeldOut) {
  expect_same_as_one_run({.method = DepthMethod::kFlow, .every = 3, .hold_out = 4});
}

TEST_F(DepthPartsTest, WorkWithAMaskAndAllThatMoves) {
  const fs::path mask = directory_ / "mask.png";
  cv::Mat valid(16, 32, CV_8UC1, cv::Scalar(255));
  valid.rowRange(13, 16).setTo(0);
  cv::imwrite(mask.string(), valid);
  expect_same_as_one_run({.every = 2, .width = 32, .valid_mask = mask, .leave_out_moving = false});
}

class DepthPartsOfALineTest : public DepthPartsTest {
 protected:
  static SyntheticRoomSpec line() {
    SyntheticRoomSpec spec = parts_spec();
    spec.cells_z = 0;
    return spec;
  }
  DepthPartsOfALineTest() : DepthPartsTest(line()) {}
};

TEST_F(DepthPartsOfALineTest, FindTheReachOfOneRun) { expect_same_as_one_run({}); }

TEST_F(DepthPartsTest, AStepNeedsThoseBeforeItAndTheSameOptions) {
  const DepthOptions options{.room = parts_, .every = 2};
  const auto error_at = [](const DepthOptions& with, DepthStep step) {
    return error_of([&] { estimate_step(with, step, {1, 2}); });
  };
  EXPECT_THAT(error_at(options, DepthStep::kSweep), HasSubstr("--step prepare first"));
  EXPECT_FALSE(fs::exists(parts_ / "distances.partial"));
  EXPECT_THAT(error_at(options, DepthStep::kPrepare), HasSubstr("in one piece"));
  estimate_step(options, DepthStep::kPrepare, {});
  EXPECT_THAT(error_at({.room = parts_, .every = 3}, DepthStep::kSweep),
              HasSubstr("of other options"));
  for (const int index : {1, 2, 4}) estimate_step(options, DepthStep::kSweep, {index, 4});
  EXPECT_THAT(error_at(options, DepthStep::kChoose),
              AllOf(HasSubstr("step sweep has to be done first"), HasSubstr("maps are missing")));
  EXPECT_THAT(error_at(options, DepthStep::kFuse), HasSubstr("step choose has to be done first"));
  EXPECT_THAT(error_at(options, DepthStep::kVolumes), HasSubstr("step fuse has to be done first"));
  // A run of its own takes over what is there and makes what is missing.
  fs::path swept;
  for (const auto& entry : fs::directory_iterator(parts_ / "distances.partial")) {
    if (entry.path().filename().string().starts_with("swept-0-")) swept = entry.path();
  }
  const auto made = fs::last_write_time(swept);
  EXPECT_THAT(error_of([&] {
                const FileLock other(parts_ / "distances.partial/lock", "", FileLock::Use::kShared);
                estimate_depth(options);
              }),
              HasSubstr("another raywalk-build-lf"));
  EXPECT_EQ(fs::last_write_time(swept), made);
  estimate_depth(options);
}

// The maps of a run that was stopped are those of one that keeps what moved; its volumes are not.
TEST_F(DepthPartsTest, WhatMovedCanBeKeptAfterwards) {
  DepthOptions options{.room = parts_, .every = 3};
  make_all(options);
  options.leave_out_moving = false;
  estimate_depth(options);
  EXPECT_FALSE(Room::open(parts_).distances(1).left_out().any(4));
}

}  // namespace
}  // namespace raywalk::build_lf
