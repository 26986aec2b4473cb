#include "render/commands/error_model_report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

// A few viewpoints are enough where the optimum itself is not tested.
constexpr int kFewViewpoints = 5;

class ErrorModelReportTest : public testing::Test {
 protected:
  ErrorModelOptions options() const {
    return {.viewpoints = kFewViewpoints, .report_dir = directory_ / "report"};
  }
  // Writes the report and returns its table.
  static std::string write(const ErrorModelOptions& options) {
    std::ostringstream table;
    write_error_model_report(options, table);
    return table.str();
  }
  std::string content(const std::string& name) const {
    return read_file(directory_ / "report" / name);
  }
  nlohmann::json json() const { return nlohmann::json::parse(content("error-model.json")); }

  TestDirectory directory_;
};

TEST_F(ErrorModelReportTest, WritesPageAndDataAndNothingElse) {
  EXPECT_THAT(write(options()), HasSubstr("N = 1 m, station step 0.01 m, 5 x 5 viewpoints"));
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_ / "report")) {
    names.push_back(entry.path().filename());
  }
  EXPECT_THAT(names, UnorderedElementsAre("index.html", "error-model.json"));
  EXPECT_THAT(content("index.html"), HasSubstr("\"kind\":\"error_model\""));
  const nlohmann::json data = json();
  const nlohmann::json& detail = data["curves"][data["detail"].get<std::size_t>()];
  EXPECT_EQ(detail["d_src_over_side"], 1.5);
  EXPECT_EQ(detail["paper_k_deg"], 76);
  const auto k = detail["optimum_k_deg"].get<std::size_t>();
  EXPECT_EQ(detail["least_e_t"], detail["e_t"][k - 45]);
}

TEST_F(ErrorModelReportTest, CoarseStepMeetsThePaperAt76) {
  ErrorModelOptions coarse = options();
  coarse.viewpoints = 49;
  coarse.step_m = 0.15;
  const std::string table = write(coarse);
  // The optimum, and the paper's.
  EXPECT_THAT(table, testing::ContainsRegex("1\\.2 +1\\.2 +78 +87 "));
  EXPECT_THAT(table, testing::ContainsRegex("1\\.5 +1\\.5 +76 +76 "));
  EXPECT_THAT(table, testing::ContainsRegex("2 +2 +75 +- "));
  EXPECT_THAT(table, testing::ContainsRegex("2\\.5 +2\\.5 +74 +72 "));
}

TEST_F(ErrorModelReportTest, DataHoldsTheCurvesOverK) {
  ErrorModelOptions scaled = options();
  scaled.side_m = 2.0;
  scaled.step_m = 0.3;
  write(scaled);
  const nlohmann::json data = json();
  EXPECT_EQ(data["side_m"], 2.0);
  EXPECT_EQ(data["step_m"], 0.3);
  EXPECT_EQ(data["viewpoints"], kFewViewpoints);
  ASSERT_EQ(data["k_deg"].size(), 46U);
  EXPECT_EQ(data["k_deg"].front(), 45);
  EXPECT_EQ(data["k_deg"].back(), 90);
  ASSERT_EQ(data["curves"].size(), 14U);  // every 0.1 N from 1.2 N to 2.5 N
  const nlohmann::json& curve = data["curves"][0];
  EXPECT_EQ(curve["d_src_over_side"], 1.2);
  EXPECT_EQ(curve["d_src_m"], 2.4);
  for (const char* name : {"e_m_rad", "e_b_rad", "e_t"}) EXPECT_EQ(curve[name].size(), 46U);
  const double share_of_bending =
      curve["e_b_rad"][0].get<double>() / curve["e_b_rad"][45].get<double>();
  EXPECT_DOUBLE_EQ(curve["e_t"][0].get<double>(), 1.0 + share_of_bending);
  EXPECT_EQ(curve["given"], true);
  EXPECT_EQ(data["curves"][1]["given"], false);
  EXPECT_EQ(data["paper"].size(), 3U);
}

TEST_F(ErrorModelReportTest, TakesDistancesInAnyOrderAndOnlyOnce) {
  ErrorModelOptions mixed = options();
  mixed.distances_over_side = {4.0, 1.0, 2.0, 1.0};
  write(mixed);
  const nlohmann::json curves = json()["curves"];
  for (std::size_t i = 1; i < curves.size(); ++i) {
    EXPECT_LT(curves[i - 1]["d_src_m"], curves[i]["d_src_m"]);
  }
  EXPECT_EQ(curves.front()["d_src_m"], 1.0);
  EXPECT_EQ(curves.back()["d_src_m"], 4.0);
  EXPECT_EQ(curves[json()["detail"].get<std::size_t>()]["d_src_m"], 2.0);  // the middle one
  mixed.distances_over_side = {1.7};
  write(mixed);
  EXPECT_EQ(json()["curves"].size(), 1U);
  EXPECT_TRUE(json()["curves"][0]["paper_k_deg"].is_null());
}

TEST_F(ErrorModelReportTest, RefusesOptionsOutsideTheirRange) {
  const auto refuses = [&](const auto& change) {
    ErrorModelOptions changed = options();
    change(changed);
    EXPECT_THAT([&] { write(changed); },
                testing::ThrowsMessage<UsageError>(HasSubstr("it must be")));
    EXPECT_FALSE(fs::exists(changed.report_dir));
  };
  const double nan = std::nan("");
  for (const double side_m : {0.0, nan, 1e300}) {
    refuses([&](ErrorModelOptions& o) { o.side_m = side_m; });
  }
  for (const double step_m : {0.0, 1e-320, nan, 1.01, -0.01, HUGE_VAL}) {
    refuses([&](ErrorModelOptions& o) { o.step_m = step_m; });
  }
  for (const int viewpoints : {0, 1001}) {
    refuses([&](ErrorModelOptions& o) { o.viewpoints = viewpoints; });
  }
  for (const double distance : {0.0, nan, 1e-300, 1e300}) {
    refuses([&](ErrorModelOptions& o) { o.distances_over_side = {1.5, distance}; });
  }
  ErrorModelOptions none = options();
  none.distances_over_side.clear();
  EXPECT_THROW(write(none), UsageError);
}

}  // namespace
}  // namespace raywalk::render
