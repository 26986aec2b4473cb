#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "build_lf/depth/depth_test_files.h"
#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/estimate_depth.h"
#include "core/base/test_error.h"
#include "core/files/file_lock.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

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
