// For tests of trades: a small synthetic room with two true views, and a clock that they set.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/evaluate/trade/trade.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

// Time that passes as a test says: every work takes the next millisecond more, so that all times
// differ and are steady; or, if busy, sometimes three times as long.
class TestClock {
 public:
  TimeSource source() {
    return [this](const std::function<void()>& work) {
      work();
      taken_s_ += 1e-6;
      return busy && ++works_ % 3 != 0 ? 3.0 * taken_s_ : taken_s_;
    };
  }
  bool busy = false;

 private:
  double taken_s_ = 1.0;
  int works_ = 0;
};

class TradeTest : public ::testing::Test {
 protected:
  TradeTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    write_image(directory_ / "near.png", render_truth(spec_, {0.4, 0.0}, 64));
    write_image(directory_ / "middle.png", render_truth(spec_, {0.0, 0.1}, 64));
    list("near.png,0.4,0,0\nmiddle.png,0,0,0.1\n");
    options_.truth = directory_ / "gt.csv";
    options_.report = directory_ / "report";
    options_.repetitions = 1;
    options_.centres = {mode(Generation::kInitial), mode(Generation::kHlfVd)};
  }
  void make_room(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }
  static ViewMode mode(Generation generation) {
    return {.options = {.generation = generation, .k_deg = 80.0}};
  }
  void list(const std::string& rows) const {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z\n" << rows;
  }
  // A few settings only, for speed.
  TradeInput input(const std::vector<ViewOptions>& parameters) const {
    TradeInput input{.room = &room_,
                     .truth = options_.truth.string(),
                     .views = captured_views(room_, read_truth(options_.truth, room_), 2),
                     .repetitions = 1,
                     .connect_viewpoints = 2,
                     .time_source = clock_.source()};
    for (const ViewOptions& options : parameters) {
      TradeSetting setting{.name = "setting " + std::to_string(input.settings.size()),
                           .mode = {.options = options},
                           .threads = thread_count()};
      if (setting.mode.options.width == 0) setting.mode.options.width = 64;
      input.settings.push_back(setting);
    }
    return input;
  }
  TradeInput few() const {
    return input({{.generation = Generation::kInitial, .k_deg = 90.0},
                  {.k_deg = 90.0},
                  {.k_deg = 45.0, .stations_mixed = 4},
                  {.k_deg = 90.0, .width = 32},
                  {.generation = Generation::kTwoSided, .k_deg = 90.0}});
  }
  std::filesystem::path partial() const { return options_.report / "trade.partial.json"; }
  nlohmann::json written() const {
    return nlohmann::json::parse(read_file(options_.report / "trade.json"));
  }
  std::string run_error() const {
    try {
      trade(room_, options_);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  mutable TestClock clock_;
  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
  TradeOptions options_;
};

}  // namespace raywalk
