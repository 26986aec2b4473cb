// Validations that were interrupted go on with what they had measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/base/test_error.h"
#include "core/evaluate/validation/validate_test_room.h"
#include "core/evaluate/validation/validation_partial.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
using nlohmann::json;

class ResumedValidateTest : public ValidateTest {
 protected:
  ResumedValidateTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    make_two_truths();
    list_with_distances(500);
  }
  // A silhouette of the first truth lies between half of its columns at 1 m and the others.
  void list_with_distances(int others_mm) const {
    cv::Mat distances(32, 64, CV_16UC1, cv::Scalar(1000));
    distances.colRange(0, 32).setTo(others_mm);
    write_image(directory_ / "distance.png", distances);
    std::ofstream(directory_ / "gt.csv")
        << "file,x,y,z,distance\nnear.png,0.4,0,0,distance.png\nmiddle.png,0,0,0,\n";
  }
  fs::path partial() const { return options_.report / "validation.partial"; }
  // As a run that ended after the first truth and the first connection error.
  void begin() const {
    fs::create_directories(options_.report);
    const ValidationPartial partial(options_.report, room_);
    std::vector<TruthView> truths = read_truth(options_.truth, room_);
    truths.resize(1);
    validate_views(room_, truths, options_.modes, partial);
    connection_errors(room_, std::span(options_.modes).first(1), options_.connect,
                      partial.connection_errors());
  }
  // The times of rendering, which no other run repeats: of the first truth's views.
  std::vector<double> times() const {
    std::vector<double> times;
    const json views = metrics()["views"];
    for (int i = 0; i < 3; ++i) times.push_back(views[i]["render_ms"]);
    return times;
  }
  std::vector<double> kept_times() const {
    std::vector<double> times;
    const ValidationPartial partial(options_.report, room_);
    const TruthView truth = read_truth(options_.truth, room_).front();
    const std::string key = partial.key_of(truth, true);
    for (ViewMode mode : options_.modes) {
      mode.options.width = truth.width;
      times.push_back(
          partial.find(ValidationPartial::key_of(key, mode.options)).value().report.render_ms);
    }
    return times;
  }
  // What does not depend on the clock.
  json timeless() const {
    json all = metrics();
    for (json* room : {&all, &all["before"]}) {
      for (json& view : (*room)["views"]) view.erase("render_ms");
      for (json& mode : (*room)["modes"]) mode.erase("median_render_ms");
    }
    return all;
  }
  // Pages differ in the times only.
  std::vector<std::string> pictures() const {
    std::vector<std::string> found;
    const std::string text = page();
    for (std::size_t at = text.find("data:image"); at != std::string::npos;
         at = text.find("data:image", at + 1)) {
      found.push_back(text.substr(at, text.find('"', at) - at));
    }
    return found;
  }
};

TEST_F(ResumedValidateTest, GoesOnWithWhatIsThere) {
  validate(room_, options_);
  const json whole = timeless();
  const std::vector<std::string> shown = pictures();
  begin();
  const std::vector<double> kept = kept_times();
  validate(room_, options_);
  EXPECT_EQ(times(), kept);
  EXPECT_EQ(timeless(), whole);
  EXPECT_EQ(pictures(), shown);
  EXPECT_FALSE(fs::exists(partial()));
}

TEST_F(ResumedValidateTest, GoesOnWithItsConnectionErrors) {
  begin();
  {
    const ValidationPartial partial(options_.report, room_);
    ConnectError kept = read_connect_error(partial.connection_errors()).at(0);
    kept.rows[1].e_connect = 1234.5;
    store_connect_error(partial.connection_errors(), kept);
  }
  validate(room_, options_);
  EXPECT_EQ(metrics()["connection_error"][1]["e_connect"], 1234.5);
}

TEST_F(ResumedValidateTest, ChangedInputsAreMeasuredAnew) {
  const auto anew = [&](const auto& change) {
    begin();
    const std::vector<double> kept = kept_times();
    change();
    validate(room_, options_);
    const bool new_times = times() != kept;
    const json resumed = timeless();
    validate(room_, options_);
    EXPECT_EQ(resumed, timeless());
    return new_times;
  };
  EXPECT_FALSE(anew([] {}));
  EXPECT_TRUE(anew([&] { list_with_distances(1000); })) << "other distances";
  EXPECT_TRUE(anew([&] { make_truth("near", {0.41, 0.0}, 64); })) << "another picture";
  EXPECT_TRUE(anew([&] { list("near.png,0.39,0,0\nmiddle.png,0,0,0\n"); })) << "another place";
  EXPECT_TRUE(anew([&] {
    write_image(directory_ / "mask.png", cv::Mat(32, 64, CV_8UC1, cv::Scalar(255)));
    std::ofstream(directory_ / "gt.csv")
        << "file,x,y,z,mask\nnear.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,\n";
  })) << "a mask";
  EXPECT_TRUE(anew([&] {
    for (ViewMode& each : options_.modes) each.options.k_deg = 70.0;
  })) << "another k";
  EXPECT_TRUE(anew([&] {
    spec_.scene.walls.max_m.x() += 0.5;
    write_synthetic_room(spec_, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  })) << "another room";
}

TEST_F(ResumedValidateTest, DamagedResultsAreMeasuredAnew) {
  begin();
  for (const auto& entry : fs::directory_iterator(partial())) {
    if (!entry.is_regular_file() || entry.path().filename() == "lock") continue;
    std::string text = read_file(entry.path());
    if (entry.path().extension() == ".png") {
      text.resize(text.size() / 2);
    } else {
      const std::size_t at = text.find("\"limited_corners\":") + 18;
      text[at] = text[at] == '3' ? '2' : '3';
    }
    std::ofstream(entry.path()) << text;
  }
  validate(room_, options_);
  const json resumed = timeless();
  validate(room_, options_);
  EXPECT_EQ(resumed, timeless());
}

TEST_F(ResumedValidateTest, TwoRunsDoNotShareAReport) {
  fs::create_directories(options_.report);
  const ValidationPartial partial(options_.report, room_);
  EXPECT_THAT(run_error(), HasSubstr("another raywalk-render validate is writing this report"));
}

}  // namespace
}  // namespace raywalk
