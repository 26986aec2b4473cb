#include "capture/config/rig_addresses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class RigAddressesTest : public ::testing::Test {
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
