#include "capture/config/capture_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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
    return read_capture_config(directory_ / "capture.yaml");
  }

  // What is wrong, from "capture.yaml:" on.
  std::string error_of(const ConfigText& text) {
    try {
      read(text);
    } catch (const UsageError& e) {
      const std::string error = e.what();
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
      return error.substr(error.find("capture.yaml"));
    }
    return "";
  }

  TestDirectory directory_;
};

TEST_F(CaptureConfigTest, AMinimalFileLeavesTheRestAtTheDefaults) {
  const CaptureConfig config = read({});
  EXPECT_EQ(config.grid.spacing_mm, 25.0);
  EXPECT_EQ(config.grid.overhang_mm, -1.0);
  EXPECT_TRUE(config.validation.empty());
  EXPECT_EQ(config.camera.kind, CameraKind::kOsc);
  EXPECT_THAT(config.camera.exposure.bracket_ev, ElementsAre(0.0));
  EXPECT_EQ(config.run.mode, CaptureMode::kStations);
  EXPECT_EQ(config.file, directory_ / "capture.yaml");
}

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

TEST_F(CaptureConfigTest, PathsAreRelativeToTheFile) {
  EXPECT_EQ(read({}).slider.register_map, directory_ / "map.yaml");
  const std::string absolute = (directory_ / "map.yaml").string();
  EXPECT_EQ(
      read({.slider = "slider: {device: a, high_limit_mm: 9, register_map: " + absolute + "}\n"})
          .slider.register_map,
      absolute);
}

TEST_F(CaptureConfigTest, MistypedKeysNameFileLineAndKey) {
  EXPECT_EQ(error_of({.rest = "run:\n  shot: 3\n"}),
            "capture.yaml:5: unknown key 'run.shot'; did you mean 'run.shots'?");
  EXPECT_EQ(error_of({.rest = "validation:\n- axis: x\n- axes: z\n"}),
            "capture.yaml:6: unknown key 'validation[1].axes'; did you mean 'validation[1].axis'?");
  EXPECT_EQ(error_of({.grid = "grid: {cell_side_m: 0}\n"}),
            "capture.yaml:1: 'grid.cell_side_m' is '0'; it must lie between 0.01 and 100");
}

TEST_F(CaptureConfigTest, AnUnknownChoiceNamesTheNearestOne) {
  EXPECT_EQ(
      error_of({.camera = "camera: {kind: ocs}\n"}),
      "capture.yaml:3: 'camera.kind' is 'ocs'; it is not a valid choice; did you mean 'osc'?");
  EXPECT_EQ(
      error_of({.rest = "run: {mode: film}\n"}),
      "capture.yaml:4: 'run.mode' is 'film'; it is not a valid choice; valid are stations, video");
  EXPECT_EQ(
      error_of({.rest = "validation:\n- axis: y\n"}),
      "capture.yaml:5: 'validation[0].axis' is 'y'; it is not a valid choice; valid are x, z");
}

TEST_F(CaptureConfigTest, AnUnknownKeyNamesTheNearestOnes) {
  EXPECT_THAT(error_of({.rest = "speed_mm_s: 5\n"}),
              HasSubstr("unknown key 'speed_mm_s'; did you mean 'slider.motion.speed_mm_s'?"));
  EXPECT_THAT(error_of({.rest = "temperature: 5\n"}),
              HasSubstr("unknown key 'temperature'; the nearest valid ones are "));
  EXPECT_LT(error_of({.rest = "temperature: 5\n"}).size(), 200U);
}

TEST_F(CaptureConfigTest, MissingSliderSettingsAreNamed) {
  EXPECT_THAT(error_of({.slider = "slider: {register_map: map.yaml, high_limit_mm: 9}\n"}),
              HasSubstr("capture.yaml: 'slider.device' is missing"));
  EXPECT_THAT(error_of({.slider = "slider: {connection: tcp, device: a, high_limit_mm: 9}\n"}),
              HasSubstr("'slider.host' is missing"));
  EXPECT_THAT(error_of({.slider = "slider: {device: a, high_limit_mm: 9}\n"}),
              HasSubstr("'slider.register_map' is missing"));
  EXPECT_THAT(
      error_of({.slider = "slider: {device: a, register_map: no.yaml, high_limit_mm: 9}\n"}),
      testing::MatchesRegex(
          "capture.yaml:2: 'slider.register_map' is '.*no.yaml', which is not a file.*"));
  EXPECT_THAT(error_of({.slider = "slider: {device: a, register_map: ., high_limit_mm: 9}\n"}),
              HasSubstr("which is not a file"));
  EXPECT_THAT(
      error_of({.slider = "slider: {device: a, register_map: sliders/leadshine-pr1.yaml, "
                          "high_limit_mm: 9}\n"}),
      AllOf(HasSubstr("relative to that file"), HasSubstr("did you mean 'leadshine-pr0'?")));
  EXPECT_THAT(error_of({.slider = "slider: {device: a, unit: 248, register_map: map.yaml, "
                                  "high_limit_mm: 9}\n"}),
              HasSubstr("capture.yaml:2: 'slider.unit' is 248"));
}

TEST_F(CaptureConfigTest, UnitsFollowTheConnection) {
  const auto unit_error = [&](const std::string& connection, int unit) {
    return error_of({.slider = "slider: {device: a, host: b, register_map: map.yaml, "
                               "high_limit_mm: 9, connection: " +
                               connection + ", unit: " + std::to_string(unit) + "}\n"});
  };
  EXPECT_EQ(unit_error("rtu", 247), "");
  EXPECT_EQ(unit_error("tcp", 255), "");
  EXPECT_THAT(unit_error("rtu", 255), HasSubstr("'slider.unit' is 255; it must lie between"));
  EXPECT_THAT(unit_error("tcp", 248), HasSubstr("'slider.unit' is 248; it must lie between"));
}

TEST_F(CaptureConfigTest, EmptyLimitsAreRefused) {
  const std::string slider = "slider:\n  device: a\n  register_map: map.yaml\n";
  EXPECT_EQ(error_of({.slider = slider}),
            "capture.yaml: 'slider.high_limit_mm' is 0; it must be above low_limit_mm, which is 0");
  EXPECT_EQ(error_of({.slider = slider + "  low_limit_mm: 90\n  high_limit_mm: 10\n"}),
            "capture.yaml:6: 'slider.high_limit_mm' is 10; it must be above low_limit_mm, which is "
            "90");
  EXPECT_THAT(error_of({.slider = slider + "  high_limit_mm: 9\n  motion:\n"
                                           "    following_error_mm: 0.05\n"}),
              HasSubstr("capture.yaml:7: 'slider.motion.following_error_mm' is 0.05"));
  EXPECT_THAT(error_of({.slider = slider + "  high_limit_mm: 9\n  motion: {stall_ms: 5}\n"}),
              HasSubstr("'slider.motion.poll_ms' is 10; it must not exceed stall_ms"));
}

TEST_F(CaptureConfigTest, ACameraNeedsItsAddress) {
  EXPECT_THAT(error_of({.camera = ""}), HasSubstr("'camera.osc.url' is ''"));
  for (const std::string url : {"192.168.1.1", "https://192.168.1.1", "http://"}) {
    EXPECT_THAT(error_of({.camera = "camera: {osc: {url: \"" + url + "\"}}\n"}),
                HasSubstr("capture.yaml:3: 'camera.osc.url' is '" + url + "'"));
  }
  EXPECT_THAT(error_of({.camera = "camera: {kind: v4l2}\n"}),
              HasSubstr("'camera.v4l2.device' is missing"));
  EXPECT_THAT(error_of({.camera = "camera: {kind: gpio}\n"}),
              HasSubstr("'trigger.shutter_line' is -1"));
  EXPECT_THAT(
      error_of({.camera = "camera: {kind: gpio}\ntrigger: {shutter_line: 4, chip: \"\"}\n"}),
      HasSubstr("'trigger.chip' is empty"));
  EXPECT_THAT(
      error_of({.camera = "camera: {kind: gpio}\ntrigger: {shutter_line: 4, focus_line: 4}\n"}),
      HasSubstr("'trigger.shutter_line' is 4, as is another line"));
  EXPECT_THAT(error_of({.camera = "camera: {kind: gpio}\n"
                                  "trigger: {shutter_line: 4, focus_line: 5, busy_line: 5}\n"}),
              HasSubstr("'trigger.busy_line' is 5, as is another line"));
}

TEST_F(CaptureConfigTest, FramesAndExposuresHaveToFitTogether) {
  const auto camera_error = [&](const std::string& keys, const std::string& rest = "") {
    return error_of({.camera = "camera: {osc: {url: \"http://a\"}, " + keys + "}\n", .rest = rest});
  };
  EXPECT_THAT(camera_error("width_px: 4096"), HasSubstr("'camera.height_px' is 0"));
  EXPECT_THAT(camera_error("height_px: 4096"), HasSubstr("'camera.width_px' is 0"));
  EXPECT_THAT(camera_error("width_px: 4096, height_px: 2000"),
              HasSubstr("'camera.width_px' is 4096 at a height of 2000"));
  EXPECT_EQ(camera_error("frames: dual-fisheye, width_px: 4096, height_px: 2000"), "");
  EXPECT_EQ(camera_error("width_px: 4096, height_px: 2048"), "");
  EXPECT_THAT(camera_error("exposure: {lock: false, iso: 100}"),
              HasSubstr("'camera.exposure.lock' is false"));
  EXPECT_THAT(camera_error("exposure: {bracket_ev: []}"), HasSubstr("is empty"));
  EXPECT_THAT(camera_error("exposure: {bracket_ev: [0, 1, 0]}"), HasSubstr("twice"));
  EXPECT_THAT(camera_error("exposure: {bracket_ev: [0, 1]}", "run: {mode: video}\n"),
              HasSubstr("which a video cannot have"));
  EXPECT_THAT(camera_error("exposure: {bracket_ev: [0]}", "run: {mode: video}\n"),
              HasSubstr("'run.mode' is video, but the program cannot film with the osc camera"));
}

TEST_F(CaptureConfigTest, ContradictoryPlansAreRefused) {
  EXPECT_THAT(error_of({.grid = "grid: {overhang_mm: -0.5}\n"}),
              HasSubstr("capture.yaml:1: 'grid.overhang_mm' is -0.5"));
  EXPECT_EQ(error_of({.rest = "validation:\n- axis: x\n  from_m: 1\n  to_m: 1\n"}),
            "capture.yaml:7: 'validation[0].to_m' is 1; it must be larger than from_m, which is 1");
  EXPECT_THAT(error_of({.rest = "scene: {nearest_m: 2, farthest_m: 1}\n"}),
              HasSubstr("capture.yaml:4: 'scene.farthest_m' is 1"));
  EXPECT_THAT(error_of({.rest = "run: {place_url: rig}\n"}), HasSubstr("'run.place_url' is 'rig'"));
}

TEST_F(CaptureConfigTest, AFileThatIsMissingIsNamed) {
  try {
    read_capture_config(directory_ / "nowhere.yaml");
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_THAT(e.what(), HasSubstr("nowhere.yaml"));
  }
}

TEST(RefuseSetting, WithoutAFileNamesTheKeyAlone) {
  try {
    refuse_setting(CaptureConfig{}, "grid.k_deg", "is odd");
    FAIL();
  } catch (const UsageError& e) {
    EXPECT_STREQ(e.what(), "'grid.k_deg' is odd");
  }
}

class RigAddressesTest : public testing::Test {
 protected:
  RigAddressesTest() { config_.camera.kind = CameraKind::kOsc; }
  std::string refusal(const std::string& rig) {
    write_file_atomically(directory_ / "rig.json", rig);
    try {
      use_rig_addresses(&config_, directory_.path());
    } catch (const UsageError& error) {
      return error.what();
    }
    return "no error";
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

}  // namespace
}  // namespace raywalk::capture
