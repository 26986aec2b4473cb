// Two rooms of one scene: in the one before, a line is exposed otherwise.
#include "core/judge/validation/before_after.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/report/markup_check.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class BeforeAfterTest : public ::testing::Test {
 protected:
  BeforeAfterTest() {
    make_rooms({.overhang_m = 0.25, .width = 64});
    write_image(directory_ / "middle.png", render_truth(spec_, {0.1, 0.2}, 64));
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z\nmiddle.png,0.1,0,0.2\n";
    options_ = {.truth = directory_ / "gt.csv",
                .before = directory_ / "before.lf",
                .report = directory_ / "report",
                .connect = {.viewpoints = 2, .k_list_deg = {76.0, 90.0}}};
    for (const Generation generation : {Generation::kInitial, Generation::kHlfVd}) {
      options_.modes.push_back({.options = {.generation = generation}, .k_source = "given"});
    }
  }
  void make_rooms(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "after.lf");
    SyntheticRoomSpec uneven = spec;
    uneven.line_gain = {{"x0", 1.25}};
    write_synthetic_room(uneven, directory_ / "before.lf");
  }
  std::string run() const { return validate(Room::open(directory_ / "after.lf"), options_); }
  std::string run_error() const {
    try {
      run();
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  json compared() const {
    return json::parse(read_file(options_.report / "metrics.json")).at("before_after");
  }
  std::string page() const { return read_file(options_.report / "index.html"); }

  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  ValidateOptions options_;
};

TEST_F(BeforeAfterTest, BothRoomsStandSideBySideWithTheGain) {
  const std::string said = run();
  const json both = compared();
  EXPECT_EQ(both["before"], (directory_ / "before.lf").string());
  ASSERT_EQ(both["means"].size(), 2U);
  for (const json& mean : both["means"]) {
    for (const char* score : {"psnr_db", "ssim"}) {
      const double before = mean["before"][score], after = mean["after"][score];
      EXPECT_GT(after, before) << score;
      EXPECT_NEAR(mean["gain"][score].get<double>(), after - before, 1e-12);
    }
  }
  ASSERT_EQ(both["connection_error"].size(), 4U);
  for (const json& row : both["connection_error"]) {
    const double before = row["before"], after = row["after"];
    EXPECT_LT(after, 0.9 * before) << row;
    EXPECT_NEAR(row["ratio"].get<double>(), after / before, 1e-12);
  }
  // Each side is what the room alone has.
  options_.before.clear();
  run();
  const json alone = json::parse(read_file(options_.report / "metrics.json"));
  EXPECT_FALSE(alone.contains("before_after"));
  EXPECT_EQ(alone["means"]["hlf-vd"], both["means"][1]["after"]);
  EXPECT_EQ(alone["connection_error"][3]["e_connect"], both["connection_error"][3]["after"]);
  EXPECT_THAT(said, AllOf(HasSubstr("gain over "), HasSubstr("E_connect at k = 90: ")));
  EXPECT_THAT(page(), Not(HasSubstr("Before and after")));
}

TEST_F(BeforeAfterTest, ThePageEmphasisesTheBetterRoom) {
  run();
  EXPECT_EQ(markup_fault(page()), "");
  const json both = compared();
  const json& mean = both["means"][1];
  const json& connection = both["connection_error"][3];
  EXPECT_THAT(
      page(),
      AllOf(HasSubstr("Before: " + options_.before.string() + " (distances: given)"),
            HasSubstr(fmt::format("<th scope=\"row\">hlf-vd</th><td>PSNR / dB</td><td>{:.2f}</td>"
                                  "<td class=\"best\">{:.2f}</td><td>{:+.2f}</td>",
                                  mean["before"]["psnr_db"].get<double>(),
                                  mean["after"]["psnr_db"].get<double>(),
                                  mean["gain"]["psnr_db"].get<double>())),
            HasSubstr(fmt::format("<th scope=\"row\">hlf-vd</th><td>90</td><td>{:.1f}</td>"
                                  "<td class=\"best\">{:.1f}</td><td>{:.3f}</td>",
                                  connection["before"].get<double>(),
                                  connection["after"].get<double>(),
                                  connection["ratio"].get<double>()))));
}

TEST_F(BeforeAfterTest, WithoutATruthConnectionsAreCompared) {
  options_.truth.clear();
  const std::string said = run();
  EXPECT_THAT(said, AllOf(HasSubstr("E_connect at k = 90: "), Not(HasSubstr("PSNR"))));
  EXPECT_EQ(compared()["connection_error"].size(), 4U);
  EXPECT_TRUE(compared()["means"].empty());
  EXPECT_TRUE(json::parse(read_file(options_.report / "metrics.json"))["means"].empty());
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_THAT(page(), AllOf(HasSubstr("Before and after"), HasSubstr("after / before"),
                            HasSubstr("connections of two rooms, without true views"),
                            Not(HasSubstr("Every view")), Not(HasSubstr("Mean over all views"))));
  EXPECT_FALSE(fs::exists(options_.report / "validation.partial"));
}

TEST_F(BeforeAfterTest, ARoomWithoutDistancesIsComparedByItsInitialViews) {
  SyntheticRoomSpec bare = spec_;
  bare.distances = false;
  bare.line_gain = {{"x0", 1.25}};
  fs::remove_all(options_.before);
  write_synthetic_room(bare, options_.before);
  run();
  ASSERT_EQ(compared()["means"].size(), 1U);
  EXPECT_EQ(compared()["means"][0]["generation"], "initial");
  EXPECT_EQ(compared()["distances_before"], "none");
  EXPECT_EQ(compared()["connection_error"].size(), 2U);
  options_.modes.erase(options_.modes.begin());
  EXPECT_THAT(run_error(),
              AllOf(HasSubstr("before.lf: has no distances"), HasSubstr("--generation initial")));
}

// Views and errors of both rooms are kept in one directory, each under its own room.
TEST_F(BeforeAfterTest, AnInterruptedRunIsResumedForBothRooms) {
  fs::create_directories(options_.report);
  const Room after = Room::open(directory_ / "after.lf");
  const Room before = Room::open(options_.before);
  {
    const ValidationPartial partial(options_.report, after);
    const ValidationPartial of_before(partial, before);
    EXPECT_NE(partial.connection_errors(), of_before.connection_errors());
    validate_views(before, read_truth(options_.truth, before), options_.modes, of_before);
    ConnectErrorOptions connect = options_.connect;
    connection_errors(before, options_.modes, connect, of_before.connection_errors());
  }
  ASSERT_TRUE(fs::exists(options_.report / "validation.partial"));
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  run();
  const std::string said =
      testing::internal::GetCapturedStderr() + testing::internal::GetCapturedStdout();
  EXPECT_THAT(said, HasSubstr("2 of 2 views are kept from earlier runs"));
  EXPECT_EQ(compared()["means"].size(), 2U);
  EXPECT_FALSE(fs::exists(options_.report / "validation.partial"));
}

TEST_F(BeforeAfterTest, NothingToCompareIsRefusedBeforeAnyWork) {
  options_.truth.clear();
  options_.before.clear();
  EXPECT_THROW(run(), UsageError);
  EXPECT_THAT(run_error(), AllOf(HasSubstr("--truth"), HasSubstr("--before")));
  options_.before = directory_ / "gone.lf";
  EXPECT_THAT(run_error(), HasSubstr("gone.lf"));
  options_.before = directory_ / "before.lf";
  make_rooms({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  EXPECT_THAT(run_error(), HasSubstr("has no cell"));
  EXPECT_FALSE(fs::exists(options_.report));
}

TEST(CompareRoomsTest, WhatWasNotMeasuredIsNull) {
  Validation before{.volume = "before.lf"}, after{.volume = "after.lf"};
  before.connection_error = {
      {.rows = {{.k_deg = 45.0, .e_connect = std::nan("")}, {.k_deg = 90.0, .e_connect = 4.0}}}};
  after.connection_error = {
      {.rows = {{.k_deg = 45.0, .e_connect = 7.0}, {.k_deg = 90.0, .e_connect = 3.0}}}};
  const json read = json::parse(before_after_json(compare_rooms(before, after)).dump());
  ASSERT_EQ(read["connection_error"].size(), 2U);
  EXPECT_TRUE(read["connection_error"][0]["before"].is_null());
  EXPECT_TRUE(read["connection_error"][0]["ratio"].is_null());
  EXPECT_EQ(read["connection_error"][1]["ratio"], 0.75);
}

}  // namespace
}  // namespace raywalk
