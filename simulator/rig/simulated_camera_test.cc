#include "simulator/rig/simulated_camera.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "simulator/rig/faults.h"
#include "simulator/rig/osc_server.h"

namespace raywalk::simulator {
namespace {

using namespace capture;
using Json = nlohmann::json;
using enum RigFault;

class SimulatedCameraTest : public testing::Test {
 protected:
  SimulatedCameraSettings settings() const {
    return {.card_directory = directory_ / "card", .frame = {64, 32}};
  }
  OscReply execute(const std::string& name, const Json& parameters = Json::object()) {
    return camera_.execute(Json{{"name", name}, {"parameters", parameters}}.dump());
  }
  // The error's code, or "done" and the like.
  std::string outcome(const std::string& name, const Json& parameters) {
    const Json reply = execute(name, parameters).json;
    return reply.contains("error") ? reply["error"]["code"] : reply["state"];
  }
  std::string set(const Json& options) {
    return outcome("camera.setOptions", {{"options", options}});
  }
  // The gain of a new picture.
  double shoot() {
    execute("camera.takePicture");
    clock_.sleep(capture::duration_from_ms(200.0));
    return gain_;
  }

  TestDirectory directory_;
  capture::ManualClock clock_;
  Faults faults_{&clock_};
  double gain_ = 0.0;
  SimulatedCamera camera_{settings(), &clock_, &faults_, [this](const ExposureNow& exposure) {
                            gain_ = exposure.gain;
                            return std::string("\xff\xd8\xff\xd9");
                          }};
};

TEST_F(SimulatedCameraTest, RefusesAsTheApiDocuments) {
  EXPECT_EQ(execute("camera.explode").http_status, 400);
  EXPECT_EQ(outcome("camera.explode", Json::object()), "unknownCommand");
  EXPECT_EQ(outcome("camera.getOptions", {{"optionNames", {"iso", "_none"}}}),
            "invalidParameterName");
  EXPECT_EQ(outcome("camera.setOptions", Json::object()), "missingParameter");
  EXPECT_EQ(set({{"iso", "many"}}), "invalidParameterValue");
  EXPECT_EQ(outcome("camera.takePicture", Json::object()), "inProgress");
  EXPECT_EQ(execute("camera.takePicture").http_status, 403);
  EXPECT_EQ(camera_.execute("no JSON").http_status, 400);
}

TEST_F(SimulatedCameraTest, OptionsAreThoseOfTheTable) {
  EXPECT_EQ(set({{"exposureProgram", 1}, {"iso", 200}}), "done");
  EXPECT_EQ(camera_.options().at("shutterSpeed"), 0.01666666) << "the metered one";
  EXPECT_NEAR(shoot(), 2.0, 1e-6);
  EXPECT_EQ(set({{"iso", 100}}), "done");
  EXPECT_NEAR(shoot(), 1.0, 1e-6);
  const Json before = camera_.options();
  for (const Json& wrong : {Json{{"iso", 101}}, Json{{"shutterSpeed", 0.0123}},
                            Json{{"_colorTemperature", 5050}}, Json{{"captureMode", "video"}}}) {
    EXPECT_EQ(set(wrong), "invalidParameterValue") << wrong;
  }
  EXPECT_EQ(set({{"iso", 200}, {"_none", 1}}), "invalidParameterName");
  EXPECT_EQ(camera_.options(), before) << "a refused command changes nothing";
  EXPECT_EQ(set({{"exposureProgram", 2}}), "done");
  EXPECT_EQ(camera_.options().at("iso"), 0);
}

TEST_F(SimulatedCameraTest, NamesContinueAfterTheFilesOnTheCard) {
  shoot();
  std::ofstream(directory_ / "card/R0010007.JPG") << "a picture";
  SimulatedCamera again(settings(), &clock_, &faults_, [](const auto&) { return "\xff\xd8"; });
  EXPECT_EQ(again.file("R0010001.JPG"), camera_.file("R0010001.JPG"));
  again.execute(R"({"name": "camera.takePicture"})");
  EXPECT_NO_THROW(again.file("R0010008.JPG"));
}

TEST_F(SimulatedCameraTest, ServersPortInUseIsAnError) {
  const OscServer server(&camera_, &faults_, 0);
  EXPECT_THROW(OscServer(&camera_, &faults_, server.port()), Error);
}

// --- Faults --------------------------------------------------------------------------------------

class FaultsTest : public ::testing::Test {
 protected:
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  bool lasts(RigFault kind) const { return faults_.lasting(kind).has_value(); }

  ManualClock clock_;
  Faults faults_{&clock_};
};

TEST_F(FaultsTest, PermanentOnesLastUntilMendedOthersOccurOnce) {
  faults_.add({.kind = kStall});
  faults_.add({.kind = kEmptyPicture});
  pass(1e6);
  EXPECT_TRUE(lasts(kStall));
  EXPECT_FALSE(lasts(kEmptyPicture));
  EXPECT_TRUE(faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  faults_.clear();
  EXPECT_FALSE(lasts(kStall));
}

TEST_F(FaultsTest, DelayAndDurationAreKept) {
  for (const RigFault kind : {kStall, kEmptyPicture}) {
    faults_.add({.kind = kind, .amount = 7.0, .for_ms = 100.0, .after_ms = 50.0});
  }
  EXPECT_FALSE(lasts(kStall));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(50.0));
  pass(50.0);
  EXPECT_EQ(faults_.lasting(kStall)->amount, 7.0);
  EXPECT_EQ(faults_.lasting(kStall)->since, clock_.now());
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(100.0));
  pass(100.0);
  EXPECT_FALSE(lasts(kStall));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.next_change(clock_.now()));
}

TEST_F(FaultsTest, EveryTriggerBeginsItsFault) {
  const std::vector<RigFault> kinds{kStall, kBusy, kCut, kLowLimit};
  faults_.add({.kind = kStall, .at_request = 2});
  faults_.add({.kind = kBusy, .at_picture = 3});
  faults_.add({.kind = kCut, .at_station = "x0_001"});
  faults_.add({.kind = kLowLimit, .at_s = 10.0});
  faults_.next_exchange();
  faults_.picture_triggered(2);
  faults_.move_commanded("x0_002");
  pass(9999.0);
  for (const RigFault kind : kinds) EXPECT_FALSE(lasts(kind));
  faults_.next_exchange();
  faults_.picture_triggered(3);
  faults_.move_commanded("x0_001");
  pass(1.0);
  for (const RigFault kind : kinds) EXPECT_TRUE(lasts(kind));
}

// They depend on the seed alone; those that are added do not change the random sequence.
TEST_F(FaultsTest, RandomOnesHaveTheGivenRatesAndRepeatForASeed) {
  LinkSettings link;
  link.late = link.lost = link.corrupted = link.duplicated = 0.02;
  Faults faults(&clock_, link), again(&clock_, link);
  again.add({.kind = kLostReply, .at_request = 10});
  again.add({.kind = kDuplicated});
  std::map<RigFault, int> counts;
  std::uint64_t all = 0;
  constexpr int kRequests = 20000;
  for (int request = 1; request <= kRequests; ++request) {
    const auto fault = faults.next_exchange(), repeated = again.next_exchange();
    EXPECT_EQ(repeated, request == 1    ? std::optional(kDuplicated)
                        : request == 10 ? std::optional(kLostReply)
                                        : fault);
    if (!fault) continue;
    ++counts[*fault];
    ++all;
  }
  for (const auto& [kind, share] :
       {std::pair{kLate, 0.02}, std::pair{kDuplicated, 0.02}, std::pair{kLostRequest, 0.02},
        std::pair{kLostReply, 0.01}, std::pair{kCorruptedReply, 0.01}}) {
    EXPECT_NEAR(counts[kind], share * kRequests, 0.2 * share * kRequests) << name_of(kind);
  }
  EXPECT_EQ(faults.exchanges(), 20000U);
  EXPECT_EQ(faults.occurred(), all);
}

}  // namespace
}  // namespace raywalk::simulator
