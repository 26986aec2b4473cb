// Two rooms of one scene: in the one before, a line is exposed otherwise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/evaluate/validation/validate.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class ValidateBeforeTest : public ::testing::Test {
 protected:
  ValidateBeforeTest() {
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
  json metrics() const { return json::parse(read_file(options_.report / "metrics.json")); }

  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  ValidateOptions options_;
};

TEST_F(ValidateBeforeTest, BothRoomsAreMeasuredAlike) {
  const std::string said = run();
  const json after = metrics(), before = after["before"];
  EXPECT_EQ(before["volume"], (directory_ / "before.lf").string());
  ASSERT_EQ(before["modes"].size(), 2U);
  for (int mode = 0; mode < 2; ++mode) {
    for (const char* score : {"psnr_db", "ssim"}) {
      EXPECT_GT(after["modes"][mode][score], before["modes"][mode][score]) << score;
    }
  }
  ASSERT_EQ(before["connection_error"].size(), 4U);
  for (int row = 0; row < 4; ++row) {
    EXPECT_LT(after["connection_error"][row]["e_connect"].get<double>(),
              0.9 * before["connection_error"][row]["e_connect"].get<double>());
  }
  EXPECT_THAT(said, AllOf(HasSubstr("gain over "), HasSubstr("PSNR +"),
                          HasSubstr("E_connect at k = 90: ")));
  // Each side is what the room alone has.
  options_.before.clear();
  run();
  EXPECT_FALSE(metrics().contains("before"));
  EXPECT_EQ(metrics()["modes"][1]["psnr_db"], after["modes"][1]["psnr_db"]);
  EXPECT_EQ(metrics()["connection_error"], after["connection_error"]);
}

TEST_F(ValidateBeforeTest, WithoutATruthConnectionsAreCompared) {
  options_.truth.clear();
  const std::string said = run();
  EXPECT_THAT(said, AllOf(HasSubstr("E_connect at k = 90: "), Not(HasSubstr("PSNR"))));
  for (const json& room : {metrics(), metrics()["before"]}) {
    EXPECT_EQ(room["connection_error"].size(), 4U);
    EXPECT_TRUE(room["modes"].empty());
  }
  EXPECT_FALSE(fs::exists(options_.report / "validation.partial"));
}

TEST_F(ValidateBeforeTest, ARoomWithoutDistancesIsComparedByItsInitialViews) {
  SyntheticRoomSpec bare = spec_;
  bare.distances = false;
  bare.line_gain = {{"x0", 1.25}};
  fs::remove_all(options_.before);
  write_synthetic_room(bare, options_.before);
  run();
  const json before = metrics()["before"];
  ASSERT_EQ(before["modes"].size(), 1U);
  EXPECT_EQ(before["modes"][0]["generation"], "initial");
  EXPECT_EQ(before["distances"], "none");
  EXPECT_EQ(before["connection_error"].size(), 2U);
  options_.modes.erase(options_.modes.begin());
  EXPECT_THAT(run_error(),
              AllOf(HasSubstr("before.lf: has no distances"), HasSubstr("--generation initial")));
}

// Views and errors of both rooms are kept in one directory, each under its own room.
TEST_F(ValidateBeforeTest, AnInterruptedRunIsResumedForBothRooms) {
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
  EXPECT_EQ(metrics()["before"]["modes"].size(), 2U);
  EXPECT_FALSE(fs::exists(options_.report / "validation.partial"));
}

TEST_F(ValidateBeforeTest, NothingToCompareIsRefusedBeforeAnyWork) {
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

}  // namespace
}  // namespace raywalk
