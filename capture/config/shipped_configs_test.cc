// The files in configs/ document the configuration; these tests check that they are complete.
#include "core/files/shipped_configs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include "capture/config/capture_config.h"
#include "capture/config/capture_schema.h"
#include "core/files/atomic_output.h"
#include "core/files/test_yaml_keys.h"

namespace raywalk::capture {
namespace {

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

TEST(WithoutExamples, LeavesOutMarkedLinesAndWhatIsUnderThem) {
  EXPECT_EQ(without_examples("a: 1\nb:  # example\n  - c: 1\n    d: 2\ne: 3  # example\nf: 4\n"),
            "a: 1\nf: 4\n");
}

}  // namespace
}  // namespace raywalk::capture
