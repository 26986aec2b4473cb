#include "core/files/settings.h"

#include <gmock/gmock.h>
#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/lens_file.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;
using ::testing::StartsWith;
namespace fs = std::filesystem;

struct ViewSettings {
  double k_deg = 76.0;
  int width = 4096;
  bool two_sided = false;
  std::string title = "untitled";
  std::string connection = "hybrid";
  double overlap_deg = 5.0;
};

SettingsSchema schema_of(ViewSettings& view) {
  SettingsSchema schema;
  schema.number("k_deg", &view.k_deg, 45.0, 90.0)
      .integer("width", &view.width, 2, 65536)
      .boolean("two_sided", &view.two_sided)
      .text("title", &view.title)
      .choice("connection", &view.connection, {"hybrid", "lfu", "rayspace360"})
      .number("blend.overlap_deg", &view.overlap_deg, 0.0, 30.0);
  return schema;
}

ViewSettings parsed(const std::string& yaml) {
  ViewSettings view;
  schema_of(view).parse(yaml, "view.yaml");
  return view;
}

std::string settings_error(const std::string& yaml) {
  return error_of([&] { parsed(yaml); });
}

TEST(Settings, SetsEveryTypeAndNestedKeys) {
  const ViewSettings view = parsed(
      "# a view\nk_deg: 80.5\nwidth: 2048\ntwo_sided: true\ntitle: \"12\"\nconnection: lfu\n"
      "blend:\n  overlap_deg: 2\n");
  EXPECT_EQ(view.k_deg, 80.5);
  EXPECT_EQ(view.width, 2048);
  EXPECT_TRUE(view.two_sided);
  EXPECT_EQ(view.title, "12");
  EXPECT_EQ(view.connection, "lfu");
  EXPECT_EQ(view.overlap_deg, 2.0);
}

TEST(Settings, UnsetKeysKeepTheirValuesAndBoundsAreInclusive) {
  EXPECT_EQ(parsed("width: 512\n").k_deg, 76.0);
  EXPECT_EQ(parsed("").width, 4096);
  EXPECT_EQ(parsed("# only a comment\n").width, 4096);
  EXPECT_EQ(parsed("k_deg: 45").k_deg, 45.0);
  EXPECT_EQ(parsed("k_deg: 90").k_deg, 90.0);
  EXPECT_EQ(settings_error("width: 512\nk_deg: 90.001"),
            "view.yaml:2: 'k_deg' is '90.001'; it must lie between 45 and 90");
  EXPECT_EQ(settings_error("width: 1"),
            "view.yaml:1: 'width' is '1'; it must lie between 2 and 65536");
}

TEST(Settings, UnknownKeysNameLineAndNearestKeyAndNoneMayBeGivenTwice) {
  EXPECT_EQ(settings_error("width: 512\nk_deg: 50\nwidth: 256\n"),
            "view.yaml:3: key 'width' appears twice");
  EXPECT_EQ(settings_error("blend: {overlap_deg: 1}\nblend: {overlap_deg: 2}\n"),
            "view.yaml:2: key 'blend.overlap_deg' appears twice");
  EXPECT_EQ(settings_error("width: 512\n\nwidht: 512\n"),
            "view.yaml:3: unknown key 'widht'; did you mean 'width'?");
  EXPECT_EQ(settings_error("blend:\n  overlap_dge: 1\n"),
            "view.yaml:2: unknown key 'blend.overlap_dge'; did you mean 'blend.overlap_deg'?");
  EXPECT_THAT(settings_error("exposure: 1\n"),
              StartsWith("view.yaml:1: unknown key 'exposure'; valid are "));
}

TEST(Settings, WrongTypesAreErrors) {
  for (const std::string bad : {"k_deg: high",    "k_deg: .nan",   "k_deg: .inf",
                                "k_deg: 1e999",   "k_deg: \"50\"", "k_deg: '50'",
                                "k_deg: [50]",    "k_deg: {a: 1}", "k_deg:",
                                "k_deg: ~",       "width: 512.0",  "width: 99999999999",
                                "two_sided: yes", "two_sided: 1",  "two_sided: \"true\"",
                                "title: [a]",     "title:",        "connection: hybird",
                                "blend: 5",       "blend:",        "blend: [overlap_deg]"}) {
    EXPECT_THAT(settings_error(bad), StartsWith("view.yaml:1: ")) << bad;
  }
  EXPECT_EQ(
      settings_error("connection: hybird"),
      "view.yaml:1: 'connection' is 'hybird'; it is not a valid choice; did you mean 'hybrid'?");
  EXPECT_EQ(settings_error("k_deg:"), "view.yaml:1: 'k_deg' has no value");
}

TEST(Settings, DocumentThatIsNotAMappingIsAnError) {
  for (const std::string bad :
       {"- k_deg", "just text", "k_deg: 50\n---\nwidth: 512\n", "? [a]\n: b", "k_deg: [", "a: b: c",
        "\t- x", "*nowhere", "{", "'open", "{k_deg: 50}, x}",
        "{k_deg: 09, bdend: &overlap_deg\x1a 1s\x1a 1}, oth`r@ *$}"}) {
    const std::string error = settings_error(bad);
    EXPECT_THAT(error, StartsWith("view.yaml:")) << bad;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  EXPECT_THAT(settings_error("width: 512\nk_deg: [\n"), HasSubstr("not valid YAML"));
}

TEST(Settings, AliasesThatMultiplyEndQuickly) {
  std::string bomb = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 60; ++i) {
    bomb += fmt::format("a{0}: &a{0} {{p: *a{1}, q: *a{1}}}\n", i, i - 1);
  }
  EXPECT_THAT(settings_error(bomb), StartsWith("view.yaml:1: unknown key 'a0'"));
  EXPECT_THAT(settings_error("blend: &b {blend: *b}"), HasSubstr("unknown key 'blend.blend'"));
}

TEST(Settings, WholeNumbersMayBeHexadecimal) {
  EXPECT_EQ(parsed("width: 0x0200").width, 512);
  EXPECT_EQ(parsed("width: 0X2aF").width, 687);
  for (const std::string bad : {"width: 0x", "width: 0xg", "width: 0x-200", "width: -0x200",
                                "width: 0x10.0", "width: 0x200000000", "width: \"0x200\""}) {
    EXPECT_THAT(settings_error(bad), StartsWith("view.yaml:1: 'width' is '")) << bad;
  }
}

struct Mark {
  std::string axis = "x";
  std::vector<double> at_m{};
};

struct Drawing {
  std::vector<double> steps{0.5};
  std::vector<std::string> layers{};
  std::vector<Mark> marks{};
  std::filesystem::path background{};
};

SettingsSchema schema_of(Drawing& drawing) {
  SettingsSchema schema;
  schema.numbers("plot.steps", &drawing.steps, -1.0, 1.0, 3)
      .words("layers", &drawing.layers, 2)
      .path("background", &drawing.background)
      .items(
          "marks",
          [&drawing] {
            Mark& mark = drawing.marks.emplace_back();
            SettingsSchema item;
            item.choice("axis", &mark.axis, {"x", "z"}).numbers("at_m", &mark.at_m, 0.0, 9.0, 2);
            return item;
          },
          2);
  return schema;
}

Drawing drawing_from(const std::string& yaml) {
  Drawing drawing;
  schema_of(drawing).parse(yaml, "plan.yaml");
  return drawing;
}

TEST(Settings, SequencesReplaceEarlierValues) {
  const Drawing drawing = drawing_from(
      "plot:\n  steps: [1, -0.25]\nlayers: [\"0x10\", grid]\nmarks:\n  - axis: z\n    at_m: [2]\n"
      "  - {}\n");
  EXPECT_THAT(drawing.steps, ElementsAre(1.0, -0.25));
  EXPECT_THAT(drawing.layers, ElementsAre("0x10", "grid"));
  ASSERT_EQ(drawing.marks.size(), 2u);
  EXPECT_EQ(drawing.marks[0].axis, "z");
  EXPECT_THAT(drawing.marks[0].at_m, ElementsAre(2.0));
  EXPECT_EQ(drawing.marks[1].axis, "x");
  EXPECT_EQ(drawing_from("background: \"a b/c.png\"").background, "a b/c.png");
  EXPECT_THAT(drawing_from("").steps, ElementsAre(0.5));
  EXPECT_THAT(drawing_from("plot: {steps: []}\nmarks: []").steps, IsEmpty());
}

TEST(Settings, MistakesInListsNameTheElementItsLineAndItsKey) {
  const std::string no_list = "1: 'marks' must be a list; start every item under it with '- '";
  const std::vector<std::pair<std::string, std::string>> mistakes{
      {"plot:\n  steps:\n    - 1\n    - 2\n",
       "4: 'plot.steps[1]' is '2'; it must lie between -1 and 1"},
      {"plot: {steps: [0, 0, 0, 0]}", "1: 'plot.steps' has 4 items; it may have 3 at most"},
      {"plot: {steps: 1}", "1: 'plot.steps' must be a list; write it as [first, second]"},
      {"plot: {steps: [1, [1]]}", "1: 'plot.steps[1]' must be a single value"},
      {"plot: {steps: [~]}", "1: 'plot.steps[0]' has no value"},
      {"plot: {steps: ['1']}", "1: 'plot.steps[0]' is '1' in quotes; write it without them"},
      {"layers: [a, b, c]", "1: 'layers' has 3 items; it may have 2 at most"},
      {"marks:\n- axis: x\n- axis: y\n",
       "3: 'marks[1].axis' is 'y'; it is not a valid choice; valid are x, z"},
      {"marks:\n- axs: x\n", "2: unknown key 'marks[0].axs'; did you mean 'marks[0].axis'?"},
      {"marks:\n- axis: x\n  axis: z\n", "3: key 'marks[0].axis' appears twice"},
      {"marks:\n- at_m: [1, 10]\n", "2: 'marks[0].at_m[1]' is '10'; it must lie between 0 and 9"},
      {"marks: [x]", "1: 'marks[0]' must be lines of 'key: value' after '- '"},
      {"marks: {axis: x}", no_list},
      {"marks:", no_list},
      {"marks: [{}, {}, {}]", "1: 'marks' has 3 items; it may have 2 at most"}};
  for (const auto& [yaml, error] : mistakes) {
    EXPECT_EQ(error_of([&yaml = yaml] { drawing_from(yaml); }), "plan.yaml:" + error) << yaml;
  }
}

TEST(Settings, LinesAreThoseOfTheValues) {
  Drawing drawing;
  const SettingsLines lines = schema_of(drawing).parse(
      "# a plan\nplot:\n  steps: [1,\n    0]\nmarks:\n  - axis: x\n  - at_m: [1]\n    axis:\n      "
      "z\n",
      "plan.yaml");
  EXPECT_THAT(lines,
              ElementsAre(Pair("marks", 6), Pair("marks[0].axis", 6), Pair("marks[1].at_m", 7),
                          Pair("marks[1].axis", 9), Pair("plot.steps", 3)));
}

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

TEST(LensFileTest, RoundTripKeepsFullPrecision) {
  const TestDirectory directory;
  const DualFisheyeCamera camera = crooked_camera();
  write_lens_file(directory / "lens.yaml", camera);
  const DualFisheyeCamera back = read_lens_file(directory / "lens.yaml");
  EXPECT_EQ(back.picture, camera.picture);
  EXPECT_TRUE(back.two_files);
  EXPECT_EQ(back.falloff_2, camera.falloff_2);
  EXPECT_EQ(back.falloff_4, camera.falloff_4);
  const DualFisheyeLayout &read = back.layout, &written = camera.layout;
  for (const auto& [a, b] : {std::pair(read.front, written.front), {read.back, written.back}}) {
    EXPECT_EQ(a.centre.u, b.centre.u);
    EXPECT_EQ(a.centre.v, b.centre.v);
    EXPECT_EQ(a.focal_px, b.focal_px);
    EXPECT_EQ(a.k, b.k);
    EXPECT_DOUBLE_EQ(a.largest_angle_rad, b.largest_angle_rad);
  }
  EXPECT_DOUBLE_EQ(read.back_attitude.yaw_rad, written.back_attitude.yaw_rad);
  EXPECT_DOUBLE_EQ(read.back_attitude.pitch_rad, written.back_attitude.pitch_rad);
  EXPECT_DOUBLE_EQ(read.back_attitude.roll_rad, written.back_attitude.roll_rad);
  EXPECT_TRUE(read.front_position_m.isApprox(written.front_position_m, 1e-15));
  EXPECT_TRUE(read.back_position_m.isApprox(written.back_position_m, 1e-15));
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
  for (const std::string key :
       {"picture_width_px", "picture_height_px", "front.centre_u_px", "front.focal_px"}) {
    const std::regex line(" *" + key.substr(key.find('.') + 1) + ":.*\n");
    expect_refused(std::regex_replace(kMinimal, line, "", std::regex_constants::format_first_only),
                   "'" + key + "' is missing");
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
  EXPECT_THROW(scaled_to(camera, {640, 480}), Error) << "another aspect ratio";
  EXPECT_NO_THROW(scaled_to(camera, {641, 320}));
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
