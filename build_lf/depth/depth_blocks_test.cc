#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "build_lf/depth/depth_test_files.h"
#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/estimate_depth.h"
#include "core/base/test_error.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A room with exposures that differ and a person, so that every step finds something.
SyntheticRoomSpec blocks_spec() {
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

// Two copies of a room: one for a single run, one for blocks.
class DepthBlocksTest : public ::testing::Test {
 protected:
  explicit DepthBlocksTest(const SyntheticRoomSpec& spec = blocks_spec()) : room_(spec, disturb) {
    fs::copy(room_.room().directory(), blocks_, fs::copy_options::recursive);
  }

  // The blocks of all steps, the last block first, and one of them twice.
  static void make_all(const DepthOptions& options) {
    for (const DepthStep step : kDepthSteps) {
      for (const int index : {3, 1, 1, 2}) estimate_block(options, step, {index, 3});
    }
  }

  void expect_same_as_one_run(DepthOptions options) {
    options.room = room_.room().directory();
    const DepthSummary plain = estimate_depth(options);
    options.room = blocks_;
    make_all(options);
    const DepthSummary merged = merge_depth(options);
    EXPECT_EQ(result_files_of(blocks_), result_files_of(room_.room().directory()));
    EXPECT_EQ(merged.maps.size(), plain.maps.size());
    EXPECT_FALSE(fs::exists(blocks_ / "distances.partial"));
  }

  DepthTestRoom room_;
  TestDirectory directory_;
  fs::path blocks_ = directory_ / "blocks.lf";
};

TEST_F(DepthBlocksTest, GiveTheRoomOfOneRun) {
  expect_same_as_one_run({.every = 3});
  const Room room = Room::open(blocks_);
  EXPECT_TRUE(room.manifest().gains) << "the exposures differ";
  EXPECT_TRUE(room.distances(1).left_out().any(4)) << "the person";
}

TEST_F(DepthBlocksTest, GiveTheMapsOfOneRunByFlowAndWithStationsHeldOut) {
  expect_same_as_one_run({.method = DepthMethod::kFlow, .every = 3, .hold_out = 4});
}

TEST_F(DepthBlocksTest, WorkWithAMaskAndAllThatMoves) {
  const fs::path mask = directory_ / "mask.png";
  cv::Mat valid(16, 32, CV_8UC1, cv::Scalar(255));
  valid.rowRange(13, 16).setTo(0);
  cv::imwrite(mask.string(), valid);
  expect_same_as_one_run({.every = 2, .width = 32, .valid_mask = mask, .leave_out_moving = false});
}

class DepthBlocksOfALineTest : public DepthBlocksTest {
 protected:
  static SyntheticRoomSpec line() {
    SyntheticRoomSpec spec = blocks_spec();
    spec.cells_z = 0;
    return spec;
  }
  DepthBlocksOfALineTest() : DepthBlocksTest(line()) {}
};

TEST_F(DepthBlocksOfALineTest, FindTheReachOfOneRun) { expect_same_as_one_run({}); }

TEST_F(DepthBlocksTest, WhatIsMissingIsNamed) {
  const DepthOptions options{.room = blocks_, .every = 2};
  EXPECT_THAT(error_of([&] { merge_depth(options); }), HasSubstr("nothing to merge"));
  estimate_block(options, DepthStep::kLinks, {1, 2});
  EXPECT_THAT(error_of([&] {
                estimate_block(options, DepthStep::kSurfaces, {1, 2});
              }),
              HasSubstr("step links: 1 of 2 blocks is missing: 2"));
  estimate_block(options, DepthStep::kLinks, {2, 2});
  for (const DepthStep step : {DepthStep::kSurfaces, DepthStep::kColours}) {
    for (const int index : {1, 2}) estimate_block(options, step, {index, 2});
  }
  for (const int index : {1, 2, 4, 8}) estimate_block(options, DepthStep::kSweep, {index, 8});
  EXPECT_THAT(error_of([&] {
                estimate_block(options, DepthStep::kChoose, {1, 1});
              }),
              HasSubstr("step sweep: 4 of 8 blocks are missing: 3 and 5 to 7"));
  EXPECT_THAT(error_of([&] { merge_depth(options); }),
              AllOf(HasSubstr("sweep: 4 of 8 blocks are missing: 3 and 5 to 7"),
                    HasSubstr("fuse: no block has been made")));
  EXPECT_THAT(error_of([&] { merge_step(options, DepthStep::kSweep); }), HasSubstr("4 of 8"));
  EXPECT_THAT(error_of([&] {
                estimate_block({.room = blocks_, .every = 3}, DepthStep::kLinks, {1, 2});
              }),
              HasSubstr("of other options"));
  // A map that was damaged is made again; a run of its own takes over all others.
  const fs::path partial = blocks_ / "distances.partial";
  fs::path swept;
  for (const auto& entry : fs::directory_iterator(partial)) {
    if (entry.path().filename().string().starts_with("swept-0-")) swept = entry.path();
  }
  fs::remove(swept);
  EXPECT_THAT(error_of([&] { merge_step(options, DepthStep::kSweep); }), HasSubstr("5 of 8"));
  estimate_depth(options);
}

// Choosing in a neighbourhood needs the swept maps around it only, fusing the chosen ones.
TEST_F(DepthBlocksTest, ChoosingAndFusingWaitForTheNeighboursOnly) {
  SyntheticRoomSpec spec = blocks_spec();
  spec.cells_x = 5;
  const DepthTestRoom wide(spec);
  const DepthOptions options{.room = wide.room().directory(), .every = 2};
  for (const DepthStep step : {DepthStep::kLinks, DepthStep::kSurfaces, DepthStep::kColours}) {
    estimate_block(options, step, {1, 1});
  }
  for (const int index : {1, 2, 3}) {  // all but the last line
    estimate_block(options, DepthStep::kSweep, {index, 4});
  }
  EXPECT_NO_THROW(estimate_block(options, DepthStep::kChoose, {1, 40}));
  EXPECT_THAT(error_of([&] {
                estimate_block(options, DepthStep::kChoose, {40, 40});
              }),
              HasSubstr("1 of 4 blocks is missing: 4"));
  EXPECT_THAT(error_of([&] {
                estimate_block(options, DepthStep::kFuse, {1, 40});
              }),
              HasSubstr("step choose: 39 of 40 blocks are missing: 2 to 40"));
}

}  // namespace
}  // namespace raywalk::build_lf
