#include "core/judge/validation/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/judge/validation/connect_error_file.h"
#include "core/report/markup_check.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;
using nlohmann::json;

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
  json metrics() const { return json::parse(read_file(options_.report / "metrics.json")); }
  std::string page() const { return read_file(options_.report / "index.html"); }

  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
  ValidateOptions options_;
};

std::set<std::string> keys_of(const json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

TEST_F(ValidateTest, WritesTheDocumentedMetrics) {
  make_room({.overhang_m = 0.25, .width = 128});
  make_two_truths();
  validate(room_, options_);
  const json all = metrics();
  EXPECT_EQ(keys_of(all),
            (std::set<std::string>{"volume", "distances", "captured_width_px", "truths",
                                   "widest_truth_px", "modes", "best", "views", "limited_views",
                                   "quarters", "quarter_gains", "connection", "connection_error",
                                   "means"}));
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["volume"], room_.directory().string());
  ASSERT_EQ(all["views"].size(), 6U);
  EXPECT_EQ(keys_of(all["views"][0]),
            (std::set<std::string>{"name", "x_m", "z_m", "line_distance_m", "generation",
                                   "connection", "k_deg", "layers", "enlargement", "psnr_db",
                                   "ws_psnr_db", "ssim", "fsim", "best", "limited_corners",
                                   "filled_share", "unseen_share", "empty_share", "render_ms"}));
  EXPECT_EQ(all["views"][0]["name"], "near");
  EXPECT_EQ(all["views"][0]["x_m"], 0.4);
  EXPECT_EQ(all["views"][0]["layers"], 0);
  EXPECT_GT(all["views"][1]["layers"], 0);
  EXPECT_EQ(all["views"][5]["generation"], "two-sided");
  EXPECT_EQ(all["views"][5]["connection"], "hybrid");
  EXPECT_EQ(keys_of(all["means"]), (std::set<std::string>{"initial", "hlf-vd", "two-sided"}));
  const double sum =
      all["views"][0]["psnr_db"].get<double>() + all["views"][3]["psnr_db"].get<double>();
  EXPECT_NEAR(all["means"]["initial"]["psnr_db"].get<double>(), sum / 2.0, 1e-9);
  EXPECT_GT(all["means"]["hlf-vd"]["psnr_db"], all["means"]["initial"]["psnr_db"]);
  ASSERT_EQ(all["connection_error"].size(), 9U);
  EXPECT_EQ(all["connection_error"][0]["connection"], "lfu");
  EXPECT_EQ(all["connection_error"][1]["connection"], "hybrid");
  EXPECT_EQ(all["connection_error"][2]["connection"], "rayspace360");
  EXPECT_EQ(all["connection_error"][3]["generation"], "hlf-vd");
  EXPECT_GE(all["connection_error"][0]["e_connect"], 0.0);
}

TEST_F(ValidateTest, TheDocumentComparesGenerations) {
  make_room({.overhang_m = 0.5, .width = 128});
  options_.connect.viewpoints = 3;  // of which some are not on a diagonal, where k has no effect
  make_two_truths();
  validate(room_, options_);
  const json all = metrics();
  ASSERT_EQ(all["modes"].size(), 3U);
  const json& best = all["best"];
  EXPECT_NE(best["generation"], "initial");
  for (const json& mode : all["modes"]) EXPECT_GE(best["psnr_db"], mode["psnr_db"]);
  EXPECT_NEAR(best["gain_db"].get<double>(),
              best["psnr_db"].get<double>() - all["modes"][0]["psnr_db"].get<double>(), 1e-9);
  for (int truth = 0; truth < 2; ++truth) {
    int best_views = 0;
    for (int mode = 0; mode < 3; ++mode) {
      best_views += all["views"][3 * truth + mode]["best"]["ssim"] ? 1 : 0;
    }
    EXPECT_EQ(best_views, 1);
  }
  // Each view has four quarters, the same of each generation.
  ASSERT_EQ(all["quarters"].size(), 24U);
  ASSERT_EQ(all["quarter_gains"].size(), 24U);
  EXPECT_EQ(all["quarter_gains"][0]["psnr_db"], 0.0);
  EXPECT_EQ(all["quarters"][4]["generation"], "hlf-vd");
  EXPECT_DOUBLE_EQ(
      all["quarter_gains"][4]["psnr_db"].get<double>(),
      all["quarters"][4]["psnr_db"].get<double>() - all["quarters"][0]["psnr_db"].get<double>());
  ASSERT_EQ(all["connection"]["comparable"], true);
  double corrected_up_to = 0.0;
  const json& rows = all["connection_error"];
  for (std::size_t i = 0; i < 9; ++i) {
    const double own = rows[i]["e_connect_common"];
    EXPECT_EQ(rows[i]["e_connect_plotted"], own);
    bool least = true;
    for (std::size_t k = i / 3 * 3; k < i / 3 * 3 + 3; ++k) {
      least = least && own <= rows[k]["e_connect_common"].get<double>();
    }
    EXPECT_EQ(rows[i]["least"], least) << i;
    if (i >= 3) corrected_up_to = std::max(corrected_up_to, own);
  }
  EXPECT_NE(rows[0]["least"], rows[1]["least"]);
  EXPECT_EQ(all["connection"]["corrected_up_to"], corrected_up_to);
}

TEST_F(ValidateTest, ThePageIsSelfContained) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_two_truths();
  const std::string said = validate(room_, options_);
  EXPECT_THAT(said, AllOf(HasSubstr("two-sided"), HasSubstr("index.html")));
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_THAT(page(), AllOf(HasSubstr("2 true viewpoints, 3 generations"),
                            HasSubstr("gain over initial views"),
                            HasSubstr("near at (0.4, 0) m, 10 cm from the nearest line"),
                            HasSubstr("at the scale of the corrected views"),
                            HasSubstr("two-sided: connection hybrid at k = 80 degrees (given)")));
  EXPECT_THAT(page(), AllOf(HasSubstr("Ground truth"), HasSubstr("half and half"),
                            HasSubstr("error, times 4"), HasSubstr("Gain in FSIM"),
                            HasSubstr("E_connect over k"), HasSubstr("data:image/jpeg")));
  EXPECT_THAT(page(), AllOf(Not(HasSubstr("src=\"http")), Not(HasSubstr("<link"))));
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(options_.report)) files += entry.exists();
  EXPECT_EQ(files, 2U);
}

TEST_F(ValidateTest, IdenticalPicturesGiveFiniteJson) {
  make_room({.scene = {.contrast = 0.0}, .width = 64});
  make_two_truths();
  validate(room_, options_);
  EXPECT_EQ(metrics()["means"]["hlf-vd"]["psnr_db"], kMaxPsnrDb);
  EXPECT_EQ(metrics()["means"]["hlf-vd"]["ws_psnr_db"], kMaxPsnrDb);
}

TEST_F(ValidateTest, AnErrorThatCannotBeMeasuredIsNull) {
  // 45 degrees lie between two columns of 5.6 degrees each, so that no column's centre is within a
  // quarter of a degree of them.
  make_room({.overhang_m = 0.25, .width = 64});
  options_.connect = {.viewpoints = 2, .overlap_deg = 0.5, .k_list_deg = {45.0}};
  make_two_truths();
  validate(room_, options_);
  const json row = metrics()["connection_error"][0];
  EXPECT_EQ(row["coverage"], 0.0);
  EXPECT_TRUE(row["e_connect"].is_null());
  EXPECT_TRUE(row["e_connect_common"].is_null());
  EXPECT_EQ(row["least"], false);
  EXPECT_THAT(page(), HasSubstr("too few to compare the angles"));
}

TEST_F(ValidateTest, ARoomWithoutDistancesHasInitialViewsOnly) {
  make_room({.width = 64, .distances = false});
  make_two_truths();
  validate(room_, options_);
  EXPECT_EQ(keys_of(metrics()["means"]), std::set<std::string>{"initial"});
  EXPECT_TRUE(metrics()["best"]["gain_db"].is_null());
  EXPECT_TRUE(metrics()["quarter_gains"].empty());
  EXPECT_EQ(markup_fault(page()), "");
  EXPECT_THAT(page(), AllOf(HasSubstr("The room has no distances"), Not(HasSubstr("Gain in PSNR")),
                            Not(HasSubstr("gain over initial")), Not(HasSubstr("class=\"best\"")),
                            Not(HasSubstr("Distances of the corrected views"))));
}

TEST_F(ValidateTest, ATruthMayHaveAnotherSize) {
  make_room({.width = 64});
  make_truth("near", {0.4, 0.0}, 128);
  make_truth("middle", {0.0, 0.0}, 64);
  list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  validate(room_, options_);
  EXPECT_EQ(metrics()["views"].size(), 6U);
}

// A dolly that is in the true views only: masked pixels affect no score.
TEST_F(ValidateTest, MaskedPixelsOfATruthAreNotCompared) {
  make_room({.width = 64});
  make_two_truths();
  validate(room_, options_);
  const json clean = metrics();
  cv::Mat mask(32, 64, CV_8UC1, cv::Scalar(255));
  mask.rowRange(24, 32).setTo(0);
  write_image(directory_ / "mask.png", mask);
  for (const char* name : {"near.png", "middle.png"}) {
    cv::Mat picture = read_panorama(directory_ / name);
    picture.setTo(cv::Scalar(0, 0, 255), mask == 0);
    write_image(directory_ / name, picture);
  }
  validate(room_, options_);
  const json unmasked = metrics();
  std::ofstream(directory_ / "gt.csv")
      << "file,x,y,z,mask\nnear.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,mask.png\n";
  validate(room_, options_);
  const json masked = metrics();
  for (const char* mode : {"initial", "hlf-vd", "two-sided"}) {
    const auto mean = [mode](const json& all, const char* metric) {
      return all["means"][mode][metric].get<double>();
    };
    EXPECT_LT(mean(unmasked, "psnr_db"), mean(clean, "psnr_db") - 3.0) << mode;
    EXPECT_GT(mean(masked, "psnr_db"), mean(unmasked, "psnr_db") + 3.0) << mode;
    EXPECT_GT(mean(masked, "ssim"), mean(unmasked, "ssim")) << mode;
    EXPECT_GT(mean(masked, "fsim"), mean(unmasked, "fsim")) << mode;
  }
}

TEST_F(ValidateTest, ASingleLineIsValidatedWithItsEmptyShare) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  make_truth("before", {0.0, -0.25}, 64);
  list("before.png,0,0,-0.25\n");
  validate(room_, options_);
  EXPECT_TRUE(metrics()["connection_error"].empty());
  EXPECT_THAT(page(), Not(HasSubstr("How well neighbouring lines connect")));
  EXPECT_THAT(page(), HasSubstr("empty"));
}

TEST_F(ValidateTest, UsesAStoredConnectionErrorOfTheSameSettings) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_two_truths();
  ConnectError stored = measure_connect_error(room_, Generation::kInitial, options_.connect);
  stored.rows[1].e_connect = 1234.5;
  store_connect_error(room_.directory(), stored);
  validate(room_, options_);
  EXPECT_EQ(metrics()["connection_error"][1]["e_connect"], 1234.5);
  options_.connect.viewpoints = 3;
  validate(room_, options_);
  EXPECT_NE(metrics()["connection_error"][1]["e_connect"], 1234.5);
}

class ResumedValidateTest : public ValidateTest {
 protected:
  ResumedValidateTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    make_two_truths();
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
    for (json& view : all["views"]) view.erase("render_ms");
    for (json& mode : all["modes"]) mode.erase("median_render_ms");
    all["best"].erase("median_render_ms");
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

TEST_F(ResumedValidateTest, NothingIsLeftWhereNothingWasMeasured) {
  fs::create_directories(options_.report);
  { const ValidationPartial nothing(options_.report, room_); }
  EXPECT_FALSE(fs::exists(partial()));
}

TEST_F(ValidateTest, AnEnlargedViewSaysByHowMuch) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_truth("near", {0.4, 0.0}, 128);
  make_truth("middle", {0.0, 0.0}, 64);
  list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  const std::string said = validate(room_, options_);
  EXPECT_THAT(said, HasSubstr("views up to 128 pixels wide are enlarged 2.0 times from panoramas "
                              "of 64"));
  EXPECT_THAT(page(), HasSubstr("enlarged 2.0 times"));
  EXPECT_EQ(metrics()["views"][0]["enlargement"], 2.0);
  EXPECT_EQ(metrics()["views"][3]["enlargement"], 1.0);
  list("middle.png,0,0,0\n");
  EXPECT_THAT(validate(room_, options_), Not(HasSubstr("enlarged")));
}

TEST_F(ValidateTest, RefusesATruthBeforeAnyWork) {
  make_room({.width = 64});
  make_two_truths();
  fs::create_directories(directory_ / "other");
  fs::copy(directory_ / "near.png", directory_ / "other" / "near.png");
  write_image(directory_ / "square.png", cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(0)));
  write_image(directory_ / "odd.png", cv::Mat(33, 66, CV_8UC3, cv::Scalar::all(0)));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"near.png,0.4,0,0\nmiddle.png,7,0,0\n", "gt.csv:3"},
      {"near.png,0.4,0,0\nother/near.png,0,0,0\n", "appears twice"},
      {"gone.png,0,0,0\n", "gone.png"},
      {"square.png,0,0,0\n", "square.png"},
      {"odd.png,0,0,0\n", "multiple of 4"},
      {"near.png,nan,0,0\n", "gt.csv:2"},
      {"", "no views"}};
  for (const auto& [rows, message] : cases) {
    list(rows);
    const std::string error = run_error();
    EXPECT_THAT(error, AllOf(HasSubstr("gt.csv"), HasSubstr(message))) << rows;
    EXPECT_EQ(error.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(options_.report)) << rows;
  }
}

TEST_F(ValidateTest, RefusesAMaskThatDoesNotFitOrLeavesNothing) {
  make_room({.width = 64});
  make_two_truths();
  write_image(directory_ / "small.png", cv::Mat(16, 32, CV_8UC1, cv::Scalar(255)));
  write_image(directory_ / "all.png", cv::Mat::zeros(32, 64, CV_8UC1));
  for (const char* mask : {"small.png", "all.png", "gone.png"}) {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z,mask\nnear.png,0.4,0,0," << mask << '\n';
    EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr(mask)));
    EXPECT_FALSE(fs::exists(options_.report)) << mask;
  }
}

TEST_F(ValidateTest, RefusesCorrectedViewsOfARoomWithoutDistances) {
  make_room({.width = 64, .distances = false});
  make_two_truths();
  options_.modes = {mode(Generation::kHlfVd)};
  EXPECT_THAT(run_error(), HasSubstr("raywalk-build-lf depth"));
  EXPECT_FALSE(fs::exists(options_.report));
}

TEST_F(ValidateTest, RefusesAnOverlapThatCannotBeMeasuredBeforeAnyWork) {
  make_room({.width = 64});
  make_two_truths();
  options_.connect.overlap_deg = 0.0;
  EXPECT_THAT(run_error(), HasSubstr("overlap is 0 degrees"));
  EXPECT_FALSE(fs::exists(options_.report));
}

TEST_F(ValidateTest, RefusesAReportThatCannotBeWritten) {
  make_room({.width = 64});
  make_two_truths();
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
}

}  // namespace
}  // namespace raywalk
