// For tests: a synthetic room and its true views.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

// Two truths of a room 64 pixels wide, listed in gt.csv: near.png 10 cm from a line, middle.png.
class TruthTest : public ::testing::Test {
 protected:
  TruthTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    make_truth("near", {0.4, 0.0}, 64);
    make_truth("middle", {0.0, 0.0}, 64);
    list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  }
  void make_room(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }
  void make_truth(const std::string& name, PlanPoint at, int width) const {
    write_image(directory_ / (name + ".png"), render_truth(spec_, at, width));
  }
  // `more`: a further column.
  void list(const std::string& rows, const std::string& more = "") const {
    std::ofstream(truth_) << "file,x,y,z" << more << '\n' << rows;
  }
  static nlohmann::json json_in(const std::filesystem::path& file) {
    return nlohmann::json::parse(read_file(file));
  }
  // What an interrupted run left, behind its checksum.
  static nlohmann::json kept_in(const std::filesystem::path& file) {
    const std::string text = read_file(file);
    return nlohmann::json::parse(text.substr(text.find('\n')));
  }
  static std::set<std::string> keys_of(const nlohmann::json& object) {
    std::set<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.insert(key);
    return keys;
  }
  // The names of the files of the report.
  std::set<std::string> files() const {
    std::set<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(report_)) {
      files.insert(entry.path().filename());
    }
    return files;
  }

  TestDirectory directory_;
  std::filesystem::path truth_ = directory_ / "gt.csv", report_ = directory_ / "report";
  SyntheticRoomSpec spec_;
  Room room_;
};

}  // namespace raywalk
