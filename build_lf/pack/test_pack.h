// For tests: packs a small capture.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_capture.h"
#include "core/base/test_error.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

class PackTest : public ::testing::Test {
 protected:
  static constexpr int kStations = TestCapture::kStations;

  Room pack() const {
    pack_room(options_);
    return Room::open(options_.out);
  }
  std::string error() const {
    return error_of([&] { pack_room(options_); });
  }
  // The error of a run that must leave neither a room nor a partial one.
  std::string clean_error() const {
    std::string message = error();
    EXPECT_FALSE(std::filesystem::exists(capture_.room())) << message;
    EXPECT_FALSE(std::filesystem::exists(capture_.partial())) << message;
    return message;
  }
  void give_maps(const std::vector<int>& frames) {
    for (const int frame : frames) capture_.write_distance_map(frame, {32, 16});
    options_.distances = capture_.distances();
  }
  void give_all_maps() {
    std::vector<int> all(kStations);
    std::iota(all.begin(), all.end(), 0);
    give_maps(all);
  }

  TestCapture capture_;
  PackOptions options_{.frames = capture_.list(), .out = capture_.room()};
};

}  // namespace raywalk::build_lf
