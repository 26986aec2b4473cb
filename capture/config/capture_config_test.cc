#include "capture/config/capture_config.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include "capture/config/capture_schema.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_support.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// A minimal configuration, which tests extend.
struct ConfigText {
  std::string grid = "grid: {cell_side_m: 1}\n";
  std::string slider =
      "slider: {device: /dev/ttyUSB0, register_map: map.yaml, high_limit_mm: 2000}\n";
  std::string camera = "camera: {osc: {url: \"http://192.168.1.1\"}}\n";
  std::string rest{};
};

class CaptureConfigTest : public testing::Test {
 protected:
  CaptureConfigTest() { write_file_atomically(directory_ / "map.yaml", "name: test\n"); }

  CaptureConfig read(const ConfigText& text) {
    write_file_atomically(directory_ / "capture.yaml",
                          text.grid + text.slider + text.camera + text.rest);
    CaptureConfig config = read_capture_config(directory_ / "capture.yaml");
    require_devices(config);
    return config;
  }

  // What is wrong, from behind "capture.yaml" on; "no error" if nothing is.
  std::string refusal(const ConfigText& text) {
    const std::string error = error_of([&] { read(text); });
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    const std::string file = "capture.yaml";
    const std::size_t at = error.find(file);
    return at == std::string::npos ? error : error.substr(at + file.size());
  }

  TestDirectory directory_;
};

TEST_F(CaptureConfigTest, EveryGroupIsRead) {
  const CaptureConfig config = read(
      {.grid = "grid: {cells_x: 2, overhang_mm: 0}\nscene: {nearest_m: 0.8}\n",
       .slider = "slider:\n  connection: tcp\n  host: 192.168.0.7\n  unit: 255\n"
                 "  register_map: map.yaml\n  high_limit_mm: 2000\n  motion: {speed_mm_s: 50}\n",
       .camera = "camera: {kind: gpio, exposure: {bracket_ev: [0, -2]}}\n"
                 "trigger: {shutter_line: 17, focus_line: 27}\n",
       .rest = "validation:\n- {axis: z, from_m: -0.4, to_m: 0.4}\n- {from_m: -0.4, to_m: 0.4}\n"
               "run: {shots: 5}\n"});
  EXPECT_EQ(config.grid.cells_x, 2);
  EXPECT_EQ(config.scene.nearest_m, 0.8);
  EXPECT_EQ(config.slider.host, "192.168.0.7");
  EXPECT_EQ(config.slider.motion.profile.speed_mm_s, 50.0);
  EXPECT_THAT(config.camera.exposure.bracket_ev, ElementsAre(0.0, -2.0));
  EXPECT_EQ(config.camera.trigger.shutter_line, 17);
  ASSERT_EQ(config.validation.size(), 2u);
  EXPECT_EQ(config.validation[0].axis, LineAxis::kZ);
  EXPECT_EQ(config.validation[1].to_m, 0.4);
  EXPECT_EQ(config.run.shots, 5);
}

TEST_F(CaptureConfigTest, APlanNeedsNoDevices) {
  write_file_atomically(directory_ / "plan.yaml", "slider: {high_limit_mm: 2000}\n");
  const CaptureConfig config = read_capture_config(directory_ / "plan.yaml");
  EXPECT_THAT(error_of([&] { require_devices(config); }),
              HasSubstr("plan.yaml: 'slider.device' is missing"));
}

TEST_F(CaptureConfigTest, PathsAreRelativeToTheFile) {
  const std::filesystem::path map = directory_ / "map.yaml";
  EXPECT_EQ(read({}).slider.register_map, map);
  const std::string slider = "slider: {device: a, high_limit_mm: 9, register_map: ";
  EXPECT_EQ(read({.slider = slider + map.string() + "}\n"}).slider.register_map, map);
}

TEST_F(CaptureConfigTest, MistakesNameFileLineAndKey) {
  const auto slider = [](const std::string& keys, const std::string& map = "map.yaml") {
    return ConfigText{.slider = "slider: {" + keys + ", register_map: " + map + "}\n"};
  };
  const auto on_line = [&](const std::string& connection, int unit) {
    return slider(fmt::format("device: a, host: b, high_limit_mm: 9, connection: {}, unit: {}",
                              connection, unit));
  };
  const auto motion = [&](const std::string& keys) {
    return slider("device: a, high_limit_mm: 9, motion: {" + keys + "}");
  };
  const auto camera = [](const std::string& keys) {
    return ConfigText{.camera = "camera: {" + keys + "}\n"};
  };
  const auto gpio = [&](const std::string& trigger) {
    return ConfigText{.camera = "camera: {kind: gpio}\n", .rest = "trigger: {" + trigger + "}\n"};
  };
  const auto pictures = [](const std::string& keys, const std::string& rest = "") {
    return ConfigText{.camera = "camera: {osc: {url: \"http://a\"}, " + keys + "}\n", .rest = rest};
  };
  const std::string video = "run: {mode: video}\n";
  struct Case {
    ConfigText text;
    std::string error;  // from the line on, or its beginning
  };
  const Case cases[] = {
      // Keys and ranges.
      {{.rest = "speed_mm_s: 5\n"},
       ":4: unknown key 'speed_mm_s'; did you mean 'slider.motion.speed_mm_s'?"},
      {{.grid = "grid: {cell_side_m: 0}\n"},
       ":1: 'grid.cell_side_m' is '0'; it must lie between 0.01 and 100"},
      // The plan.
      {{.grid = "grid: {overhang_mm: -0.5}\n"}, ":1: 'grid.overhang_mm' is -0.5"},
      {{.rest = "validation:\n- axis: x\n  from_m: 1\n  to_m: 1\n"},
       ":7: 'validation[0].to_m' is 1; it must be larger than from_m, which is 1"},
      {{.rest = "scene: {nearest_m: 2, farthest_m: 1}\n"}, ":4: 'scene.farthest_m' is 1"},
      {{.rest = "run: {place_url: rig}\n"}, ":4: 'run.place_url' is 'rig'"},
      // The slider.
      {slider("high_limit_mm: 9"), ": 'slider.device' is missing"},
      {slider("connection: tcp, device: a, high_limit_mm: 9"), ": 'slider.host' is missing"},
      {on_line("rtu", 247), "no error"},
      {on_line("tcp", 255), "no error"},
      {on_line("rtu", 255), ":2: 'slider.unit' is 255; it must lie between"},
      {on_line("tcp", 248), ":2: 'slider.unit' is 248; it must lie between"},
      {slider("device: a"),
       ": 'slider.high_limit_mm' is 0; it must be above low_limit_mm, which is 0"},
      {slider("device: a, low_limit_mm: 90, high_limit_mm: 10"),
       ":2: 'slider.high_limit_mm' is 10; it must be above low_limit_mm"},
      {motion("following_error_mm: 0.05"), ":2: 'slider.motion.following_error_mm' is 0.05"},
      {motion("stall_ms: 5"), ": 'slider.motion.poll_ms' is 10; it must not exc"},
      {{.slider = "slider: {device: a, high_limit_mm: 9}\n"}, ": 'slider.register_map' is missing"},
      // The camera.
      {{.camera = ""}, ": 'camera.osc.url' is ''"},
      {camera("osc: {url: 192.168.1.1}"), ":3: 'camera.osc.url' is '192.168.1.1'"},
      {camera("osc: {url: \"https://a\"}"), ":3: 'camera.osc.url' is 'https://a'"},
      {camera("osc: {url: \"http://\"}"), ":3: 'camera.osc.url' is 'http://'"},
      {camera("kind: v4l2"), ": 'camera.v4l2.device' is missing"},
      {camera("kind: gpio"), ": 'trigger.shutter_line' is -1"},
      {gpio("shutter_line: 4, chip: \"\""), ":4: 'trigger.chip' is empty"},
      {gpio("shutter_line: 4, focus_line: 4"),
       ":4: 'trigger.shutter_line' is 4, as is another line"},
      {gpio("shutter_line: 4, focus_line: 5, busy_line: 5"),
       ":4: 'trigger.busy_line' is 5, as is another line"},
      // Its pictures.
      {pictures("width_px: 4096"), ": 'camera.height_px' is 0"},
      {pictures("height_px: 4096"), ": 'camera.width_px' is 0"},
      {pictures("width_px: 4096, height_px: 2000"),
       ":3: 'camera.width_px' is 4096 at a height of 2000"},
      {pictures("frames: dual-fisheye, width_px: 4096, height_px: 2000"), "no error"},
      {pictures("width_px: 4096, height_px: 2048"), "no error"},
      {pictures("exposure: {lock: false, iso: 100}"), ":3: 'camera.exposure.lock' is false"},
      {pictures("exposure: {bracket_ev: []}"), ":3: 'camera.exposure.bracket_ev' is empty"},
      {pictures("exposure: {bracket_ev: [0, 1, 0]}"),
       ":3: 'camera.exposure.bracket_ev' holds an exposure twice"},
      {pictures("exposure: {bracket_ev: [0, 1]}", video),
       ":3: 'camera.exposure.bracket_ev' holds more than one exposure, which a "},
      {pictures("exposure: {bracket_ev: [0]}", video),
       ":4: 'run.mode' is video, but the program cannot record video with the osc"}};
  for (const auto& [text, error] : cases) EXPECT_THAT(refusal(text), StartsWith(error));
  for (const char* map : {"no.yaml", "."}) {
    EXPECT_THAT(
        refusal(slider("device: a, high_limit_mm: 9", map)),
        AllOf(StartsWith(":2: 'slider.register_map' is '"), HasSubstr("which is not a file")));
  }
  EXPECT_THAT(refusal(slider("device: a, high_limit_mm: 9", "sliders/leadshine-pr1.yaml")),
              AllOf(HasSubstr("relative to that file"), HasSubstr("did you mean 'leadshine-pr0'")));
  EXPECT_THAT(error_of([&] { read_capture_config(directory_ / "nowhere.yaml"); }),
              HasSubstr("nowhere.yaml"));
  EXPECT_EQ(error_of([] { refuse_setting(CaptureConfig{}, "grid.k_deg", "is odd"); }),
            "'grid.k_deg' is odd");
  EXPECT_THROW(refuse_setting(CaptureConfig{}, "grid.k_deg", "is odd"), UsageError);
}

class RigAddressesTest : public testing::Test {
 protected:
  RigAddressesTest() { config_.camera.kind = CameraKind::kOsc; }
  std::string refusal(const std::string& rig) {
    write_file_atomically(directory_ / "rig.json", rig);
    return error_of([&] { use_rig_addresses(&config_, directory_.path()); });
  }
  TestDirectory directory_;
  CaptureConfig config_;
};

TEST_F(RigAddressesTest, AreThoseOfTheRunningRig) {
  EXPECT_EQ(refusal(R"({"slider": "", "modbus_port": 5020, "camera_url": "http://127.0.0.1:9"})"),
            "no error");
  EXPECT_EQ(config_.slider.port, 5020);
  EXPECT_EQ(config_.camera.osc.url, "http://127.0.0.1:9");
  EXPECT_EQ(config_.run.place_url, "http://127.0.0.1:9/rig/place");
}

// 4294972316 is 5020 modulo 2^32.
TEST_F(RigAddressesTest, ValuesThatNoRigWritesAreNamed) {
  for (const char* port : {"4294972316", "0", "-1", "65536", "5020.5", "\"5020\"", "null"}) {
    EXPECT_THAT(refusal(std::string(R"({"slider": "", "modbus_port": )") + port +
                        R"(, "camera_url": "http://127.0.0.1:9"})"),
                AllOf(HasSubstr("rig.json: modbus_port: " + std::string(port)),
                      HasSubstr("between 1 and 65535"), HasSubstr("start the simulated rig again")))
        << port;
  }
  EXPECT_THAT(refusal("{}"), HasSubstr("rig.json: has no 'slider'"));
  EXPECT_THAT(refusal("{"), HasSubstr("rig.json: damaged"));
}

// The files in configs/ document the configuration; these tests check that they are complete.

const char* const kFiles[] = {"capture-osc.yaml", "capture-gpio.yaml", "capture-v4l2.yaml"};

std::filesystem::path shipped(const std::string& name) {
  return std::filesystem::path(RAYWALK_CONFIGS) / name;
}

std::size_t indent_of(const std::string& line) { return line.find_first_not_of(' '); }

// The file without the lines marked as examples and the lines indented under them.
std::string without_examples(const std::string& yaml) {
  std::istringstream lines(yaml);
  std::string kept;
  std::size_t example_indent = std::string::npos;
  for (std::string line; std::getline(lines, line);) {
    if (example_indent != std::string::npos && indent_of(line) != std::string::npos &&
        indent_of(line) > example_indent) {
      continue;
    }
    const bool is_example = line.ends_with("# example");
    example_indent = is_example ? indent_of(line) : std::string::npos;
    if (!is_example) kept += line + "\n";
  }
  return kept;
}

TEST(ShippedCaptureConfigs, AreRead) {
  for (const std::string& name : shipped_config_names(ConfigKind::kCapture)) {
    EXPECT_NO_THROW(read_capture_config(shipped(name + ".yaml"))) << name;
  }
  EXPECT_EQ(read_capture_config(shipped("capture-osc.yaml")).camera.kind, CameraKind::kOsc);
  EXPECT_EQ(read_capture_config(shipped("capture-gpio.yaml")).camera.kind, CameraKind::kGpio);
  EXPECT_EQ(read_capture_config(shipped("capture-v4l2.yaml")).camera.kind, CameraKind::kV4l2);
}

TEST(ShippedCaptureConfigs, TogetherHoldEveryKey) {
  std::set<std::string> held;
  for (const char* name : kFiles) held.merge(keys_of_yaml(shipped(name)));
  CaptureConfig config;
  std::set<std::string> known;
  for (const auto& entry : capture_schema(&config).values()) known.insert(entry.first);
  EXPECT_EQ(held, known);
}

// A key is explained where it first appears by a comment above it, or above the keys that precede
// it without an empty line. Groups need no explanation of their own.
TEST(ShippedCaptureConfigs, ExplainEveryKeyWhereItFirstAppears) {
  std::set<std::string> explained;
  for (const char* name : kFiles) {
    std::istringstream lines(read_file(shipped(name)));
    bool under_comment = false;
    std::set<std::string> here;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t begin = line.find_first_not_of(" -");
      if (begin == std::string::npos) {
        under_comment = false;
      } else if (line[begin] == '#') {
        under_comment = true;
      } else if (!line.ends_with(':')) {
        const std::string key = line.substr(begin, line.find(':') - begin);
        EXPECT_TRUE(under_comment || explained.contains(key)) << name << ": " << line;
        here.insert(key);
      }
    }
    explained.merge(here);
  }
}

TEST(ShippedCaptureConfigs, ValuesThatAreNoExamplesAreTheDefaults) {
  CaptureConfig defaults;
  const auto default_values = capture_schema(&defaults).values();
  for (const char* name : kFiles) {
    CaptureConfig config;
    capture_schema(&config).parse(without_examples(read_file(shipped(name))), name);
    EXPECT_TRUE(config.validation.empty()) << name;
    EXPECT_EQ(capture_schema(&config).values(), default_values) << name;
  }
}

}  // namespace
}  // namespace raywalk::capture
