#include "core/files/shipped_configs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

// Tests run from the build directory, which has the files where an installation does.
TEST(ShippedConfigs, AreKnownByKind) {
  EXPECT_THAT(shipped_config_names(ConfigKind::kSlider), Contains("leadshine-pr0"));
  EXPECT_THAT(shipped_config_names(ConfigKind::kCapture),
              AllOf(Contains("capture-osc"), Contains("rehearsal-capture"), Not(Contains("view"))));
  EXPECT_THAT(shipped_config_names(ConfigKind::kView), Each(HasSubstr("view")));
  EXPECT_THAT(shipped_config_names(ConfigKind::kRig), Contains("simulated-rig"));
  EXPECT_THAT(shipped_config_names(ConfigKind::kVirtualRoom), Contains("virtual-room"));
}

TEST(ShippedConfigs, AreFoundByNameWithOrWithoutFolders) {
  const fs::path lens = shipped_configs(ConfigKind::kLens) / "theta-like.yaml";
  EXPECT_TRUE(fs::is_regular_file(lens));
  for (const char* name :
       {"theta-like", "theta-like.yaml", "lenses/theta-like", "configs/lenses/theta-like.yaml"}) {
    EXPECT_EQ(config_path(name, ConfigKind::kLens, "/nowhere"), lens) << name;
  }
  const fs::path capture = shipped_configs(ConfigKind::kCapture) / "capture-osc.yaml";
  EXPECT_EQ(config_path("capture-osc", ConfigKind::kCapture), capture);
  EXPECT_EQ(config_path("configs/capture-osc.yaml", ConfigKind::kCapture, "/nowhere"), capture);
  for (const char* other :
       {"/nowhere/theta-like", "theta-like.txt", "hall/theta-like", "view", "sliders/theta-like"}) {
    EXPECT_EQ(config_path(other, ConfigKind::kLens), other);
  }
}

TEST(ShippedConfigs, GiveWayToAFileAsItIsWritten) {
  const TestDirectory directory;
  fs::create_directory(directory / "generic");
  EXPECT_EQ(config_path("generic", ConfigKind::kSlider, directory.path()),
            shipped_configs(ConfigKind::kSlider) / "generic.yaml");
  write_file_atomically(directory / "theta-like", "picture_width_px: 8\n");
  EXPECT_EQ(config_path("theta-like", ConfigKind::kLens, directory.path()),
            directory / "theta-like");
}

TEST(ShippedConfigs, AreSuggestedForWhatIsNeitherFileNorName) {
  EXPECT_THAT(missing_config_text("/rig/lenses/theta-lik.yaml", ConfigKind::kLens),
              AllOf(HasSubstr("is '/rig/lenses/theta-lik.yaml', which is not a file"),
                    HasSubstr(shipped_configs(ConfigKind::kLens).string()),
                    HasSubstr("; did you mean 'theta-like'?")));
  EXPECT_THAT(missing_config_text("capture", ConfigKind::kCapture),
              HasSubstr("valid are capture-gpio, capture-osc, capture-v4l2"));
  const std::string here = (fs::current_path() / "b.yaml").string();
  EXPECT_THAT(missing_config_text("b.yaml", ConfigKind::kSlider),
              AllOf(HasSubstr("is '" + here + "'"), HasSubstr("leadshine-pr0")));
}

}  // namespace
}  // namespace raywalk
