#include "core/files/shipped_configs.h"

#include <gmock/gmock.h>

namespace raywalk {
namespace {

using testing::HasSubstr;

// Tests run from the build directory, which is below the sources.
TEST(ShippedConfigs, AreFoundAboveTheProgram) {
  EXPECT_TRUE(std::filesystem::is_regular_file(shipped_configs("sliders") / "leadshine-pr0.yaml"));
  EXPECT_TRUE(std::filesystem::is_regular_file(shipped_configs("") / "capture-osc.yaml"));
  EXPECT_EQ(shipped_configs("nowhere"), "configs/nowhere");
}

TEST(ShippedConfigs, AreNamedWithWhatWasLookedFor) {
  EXPECT_THAT(missing_config_text("/rig/sliders/a.yaml", "sliders"),
              testing::AllOf(HasSubstr("is '/rig/sliders/a.yaml', which is not a file"),
                             HasSubstr(shipped_configs("sliders").string())));
  const std::string here = (std::filesystem::current_path() / "b.yaml").string();
  EXPECT_THAT(missing_config_text("b.yaml", ""), HasSubstr("is '" + here + "'"));
}

}  // namespace
}  // namespace raywalk
