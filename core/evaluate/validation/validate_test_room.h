// For tests: a synthetic room with truths, validated.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/evaluate/validation/validate.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

class ValidateTest : public ::testing::Test {
 protected:
  void make_room(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
    options_.truth = directory_ / "gt.csv";
    options_.report = directory_ / "report";
    options_.connect = {.viewpoints = 2, .k_list_deg = {45.0, 76.0, 90.0}};
    options_.modes = {mode(Generation::kInitial)};
    if (!spec.distances) return;
    options_.modes.push_back(mode(Generation::kHlfVd));
    options_.modes.push_back(mode(Generation::kTwoSided));
  }
  static ViewMode mode(Generation generation) {
    return {.options = {.generation = generation, .k_deg = 80.0}, .k_source = "given"};
  }
  void make_truth(const std::string& name, PlanPoint at, int width) const {
    write_image(directory_ / (name + ".png"), render_truth(spec_, at, width));
  }
  void list(const std::string& rows) const {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z\n" << rows;
  }
  void make_two_truths() const {
    make_truth("near", {0.4, 0.0}, 64);
    make_truth("middle", {0.0, 0.0}, 64);
    list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  }
  std::string run_error() const {
    try {
      validate(room_, options_);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  nlohmann::json metrics() const {
    return nlohmann::json::parse(read_file(options_.report / "metrics.json"));
  }
  std::string page() const { return read_file(options_.report / "index.html"); }

  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
  ValidateOptions options_;
};

}  // namespace raywalk
