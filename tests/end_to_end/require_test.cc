// End-to-end test of raywalk-build-lf require, and of raywalk-render with its stored results.
// RAYWALK_BUILD_LF and RAYWALK_RENDER are the programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "build_lf/pack/test_capture.h"
#include "core/files/atomic_output.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

class RequireCommandTest : public ::testing::Test {
 protected:
  static CommandResult build_lf(const std::string& arguments) {
    return run_command(std::string(RAYWALK_BUILD_LF) + " " + arguments);
  }
  void pack(bool distances) const {
    if (distances) {
      for (int i = 0; i < TestCapture::kStations; ++i) capture_.write_distance_map(i, {32, 16});
    }
    const CommandResult packed =
        build_lf("pack --frames " + capture_.list().string() + " --out " + room_ +
                 (distances ? " --distance " + capture_.distances().string() : std::string()));
    ASSERT_EQ(packed.exit_code, 0) << packed.errors;
  }
  CommandResult view() const {
    return run_command(std::string(RAYWALK_RENDER) + " view " + room_ + " --at 0,0 --out " +
                       (capture_.root() / "view.png").string());
  }

  TestCapture capture_;
  std::string room_ = capture_.room().string();
  std::string thin_ = (capture_.root() / "thin.lf").string();
  std::string report_ = (capture_.root() / "report").string();
};

TEST_F(RequireCommandTest, MeasuresAndThins) {
  pack(true);
  const CommandResult required =
      build_lf("require " + room_ + " --thin " + thin_ + " --report " + report_);
  ASSERT_EQ(required.exit_code, 0) << required.errors;
  EXPECT_THAT(required.output,
              AllOf(HasSubstr("layers"), HasSubstr("spacing"), HasSubstr("index.html")));
  EXPECT_EQ(build_lf("verify " + thin_).exit_code, 0);
  const auto json = nlohmann::json::parse(read_file(fs::path(report_) / "require.json"));
  EXPECT_EQ(json["spacing"]["stations"], TestCapture::kStations);
  EXPECT_EQ(json["thinned"]["room"], thin_);
  const CommandResult rendered = view();
  EXPECT_EQ(rendered.exit_code, 0) << rendered.errors;
}

TEST_F(RequireCommandTest, FailuresGiveOneErrorLineAndLeaveNothing) {
  pack(false);
  const CommandResult blind = build_lf("require " + room_ + " --thin " + thin_);
  EXPECT_EQ(blind.exit_code, 1);
  EXPECT_THAT(blind.errors,
              AllOf(HasSubstr("raywalk-build-lf depth"), HasSubstr("pack --distance")));
  EXPECT_FALSE(fs::exists(thin_));
  EXPECT_FALSE(fs::exists(fs::path(room_) / "require.json"));
  const CommandResult nan = build_lf("require " + room_ + " --tolerance-px nan");
  EXPECT_EQ(nan.exit_code, 2);
  EXPECT_THAT(nan.errors, HasSubstr("--tolerance-px"));
}

}  // namespace
}  // namespace raywalk::build_lf
