#include "core/files/lens_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using testing::Contains;
using testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kMinimal =
    "picture_width_px: 400\npicture_height_px: 200\n"
    "front:\n  centre_u_px: 99.5\n  centre_v_px: 99.5\n  focal_px: 59\n"
    "back:\n  centre_u_px: 299.5\n  centre_v_px: 99.5\n  focal_px: 59\n";

DualFisheyeCamera parsed_lens(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "lens.yaml", yaml);
  return read_lens_file(directory / "lens.yaml");
}

void expect_refused(const std::string& yaml, const std::string& message) {
  EXPECT_THAT(error_of([&] { parsed_lens(yaml); }),
              AllOf(HasSubstr("lens.yaml"), HasSubstr(message), Not(HasSubstr("\n"))));
}

std::string without_line_of(std::string yaml, const std::string& key) {
  const std::size_t at = yaml.find(key);
  const std::size_t begin = yaml.rfind('\n', at) + 1;
  return yaml.erase(begin, yaml.find('\n', at) + 1 - begin);
}

DualFisheyeCamera crooked_camera() {
  DualFisheyeCamera camera;
  camera.picture = {5760, 2880};
  camera.two_files = true;
  camera.layout = simple_dual_fisheye(camera.picture);
  camera.layout.front.centre = {1.0 / 3.0 + 1430.0, 1441.7};
  camera.layout.front.k = {0.03, -1.0 / 300.0, 2e-7, -1e-17};
  camera.layout.back.focal_px *= 1.003;
  camera.layout.back.largest_angle_rad = radians_from_degrees(97.3);
  camera.layout.back_attitude = {radians_from_degrees(-179.7), 0.004, -0.006};
  camera.layout.front_position_m = {0.0001, -0.0002, 0.0051};
  camera.layout.back_position_m = {-0.0001, 0.0003, -0.0049};
  camera.falloff_2 = -0.1 / 3.0;
  camera.falloff_4 = -0.02;
  return camera;
}

void expect_same(const FisheyeLens& a, const FisheyeLens& b) {
  EXPECT_EQ(a.centre.u, b.centre.u);
  EXPECT_EQ(a.centre.v, b.centre.v);
  EXPECT_EQ(a.focal_px, b.focal_px);
  EXPECT_EQ(a.k, b.k);
  EXPECT_DOUBLE_EQ(a.largest_angle_rad, b.largest_angle_rad);
}

TEST(LensFileTest, RoundTripKeepsFullPrecision) {
  const TestDirectory directory;
  const DualFisheyeCamera camera = crooked_camera();
  write_lens_file(directory / "lens.yaml", camera);
  const DualFisheyeCamera back = read_lens_file(directory / "lens.yaml");
  EXPECT_EQ(back.picture, camera.picture);
  EXPECT_TRUE(back.two_files);
  EXPECT_EQ(back.falloff_2, camera.falloff_2);
  EXPECT_EQ(back.falloff_4, camera.falloff_4);
  expect_same(back.layout.front, camera.layout.front);
  expect_same(back.layout.back, camera.layout.back);
  EXPECT_DOUBLE_EQ(back.layout.back_attitude.yaw_rad, camera.layout.back_attitude.yaw_rad);
  EXPECT_DOUBLE_EQ(back.layout.back_attitude.pitch_rad, camera.layout.back_attitude.pitch_rad);
  EXPECT_DOUBLE_EQ(back.layout.back_attitude.roll_rad, camera.layout.back_attitude.roll_rad);
  EXPECT_TRUE(back.layout.front_position_m.isApprox(camera.layout.front_position_m, 1e-15));
  EXPECT_TRUE(back.layout.back_position_m.isApprox(camera.layout.back_position_m, 1e-15));
}

TEST(LensFileTest, DefaultIsBackToBackAtOnePosition) {
  const DualFisheyeCamera camera = parsed_lens(kMinimal);
  EXPECT_FALSE(camera.two_files);
  EXPECT_EQ(camera.layout.back.centre.u, 299.5);
  EXPECT_DOUBLE_EQ(camera.layout.back_attitude.yaw_rad, kPi);
  EXPECT_EQ(camera.layout.back_attitude.pitch_rad, 0.0);
  EXPECT_EQ(camera.layout.back_position_m.norm(), 0.0);
  EXPECT_EQ(camera.layout.front.k, FisheyeLens{}.k);
}

TEST(LensFileTest, KeysWithoutDefaultsAreRequired) {
  for (const char* key : {"picture_width_px", "picture_height_px"}) {
    expect_refused(without_line_of(kMinimal, key), std::string("'") + key + "' is missing");
  }
  for (const char* key : {"centre_u_px", "centre_v_px", "focal_px"}) {
    expect_refused(without_line_of(kMinimal, key), std::string("'front.") + key + "' is missing");
  }
  expect_refused(std::string(kMinimal).substr(0, std::string(kMinimal).find("back:")),
                 "'back.centre_u_px' is missing");
}

TEST(LensFileTest, MistakesAreNamed) {
  expect_refused(std::string(kMinimal) + "  focal_mm: 3\n", "did you mean 'back.focal_px'");
  expect_refused(std::string(kMinimal) + "  k1: much\n", "back.k1");
  expect_refused(std::string(kMinimal) + "  largest_angle_deg: 190\n", "back.largest_angle_deg");
  expect_refused(std::string(kMinimal) + "  k1: -0.3\n", "back: the radius of the fisheye lens");
  EXPECT_THROW(read_lens_file("no/such/lens.yaml"), UsageError);
}

// A direction has the same relative position, measured from the corner, at any picture size.
TEST(LensFileTest, ScaledCameraKeepsRelativePixelPositions) {
  const DualFisheyeCamera camera = crooked_camera();
  const DualFisheyeCamera small = scaled_to(camera, {640, 320});
  EXPECT_EQ(small.picture.width, 640);
  for (const double theta : {-1.6, -0.4, 0.0, 0.9}) {
    const Eigen::Vector3d direction = direction_from_angles({theta, 0.3});
    const auto large_at = project(camera.layout.front, direction);
    const auto small_at = project(small.layout.front, direction);
    ASSERT_TRUE(large_at && small_at);
    EXPECT_NEAR((small_at->u + 0.5) / 640, (large_at->u + 0.5) / 5760, 1e-12);
    EXPECT_NEAR((small_at->v + 0.5) / 320, (large_at->v + 0.5) / 2880, 1e-12);
  }
  EXPECT_EQ(small.layout.back_position_m, camera.layout.back_position_m);
}

TEST(LensFileTest, OtherAspectRatiosAreRejected) {
  EXPECT_THROW(scaled_to(crooked_camera(), {640, 480}), Error);
  EXPECT_NO_THROW(scaled_to(crooked_camera(), {641, 320}));
}

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
              HasSubstr("valid are capture-gpio, capture-insta360, capture-osc, "));
  const std::string here = (fs::current_path() / "b.yaml").string();
  EXPECT_THAT(missing_config_text("b.yaml", ConfigKind::kSlider),
              AllOf(HasSubstr("is '" + here + "'"), HasSubstr("leadshine-pr0")));
}

}  // namespace
}  // namespace raywalk
