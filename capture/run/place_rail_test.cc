#include "capture/run/place_rail.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "capture/session/test_session.h"

namespace raywalk::capture {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const CaptureLine kLine = test_line("z1", LineAxis::kZ, 0.5, -0.75, 0.25, 7);

// A rig that answers requests to place the rail with the given status.
class RigServer {
 public:
  explicit RigServer(int status) {
    server_.Post("/rig/place",
                 [this, status](const httplib::Request& request, httplib::Response& reply) {
                   request_ = request.body;
                   reply.status = status;
                   reply.set_content("no such line", "text/plain");
                 });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~RigServer() {
    server_.stop();
    thread_.join();
  }
  RunConfig config() const {
    RunConfig config;
    config.place_url = "http://127.0.0.1:" + std::to_string(port_) + "/rig/place";
    return config;
  }
  const std::string& request() const { return request_; }

 private:
  httplib::Server server_;
  std::thread thread_;
  int port_ = 0;
  std::string request_;
};

TEST(PlacementText, SaysWhereBothEndsOfTheLineBelong) {
  EXPECT_THAT(
      placement_text(kLine, 4, 5),
      AllOf(HasSubstr("z1 (4 of 5)"), HasSubstr("50.0 mm belongs at x = +0.500 m, z = -0.750 m"),
            HasSubstr("towards +z"), HasSubstr("z = +0.750 m at 1550.0 mm")));
}

TEST(PlaceRail, SendsTheLineToARigThatPlacesItself) {
  const RigServer rig(200);
  place_rail(rig.config(), false, kLine, 1, 1);
  const auto request = nlohmann::json::parse(rig.request());
  EXPECT_EQ(request["line"], "z1");
  EXPECT_EQ(request["placement"], 1);
  EXPECT_EQ(request["start_m"], nlohmann::json({0.5, -0.75}));
  EXPECT_EQ(request["end_m"], nlohmann::json({0.5, 0.75}));
}

TEST(PlaceRail, ARefusalOfTheRigIsAnErrorWithItsAnswer) {
  const RigServer rig(404);
  const std::string error = error_of([&] { place_rail(rig.config(), false, kLine, 1, 1); });
  EXPECT_THAT(error, AllOf(HasSubstr("z1"), HasSubstr("404"), HasSubstr("no such line")));
}

TEST(PlaceRail, ARigThatIsOffIsAnError) {
  RunConfig config;
  config.place_url = "http://127.0.0.1:1/rig/place";
  config.place_timeout_ms = 500.0;
  const std::string error = error_of([&] { place_rail(config, false, kLine, 1, 1); });
  EXPECT_THAT(error, AllOf(HasSubstr("127.0.0.1:1"), HasSubstr("run.place_timeout_ms")));
}

TEST(PlaceRail, YesDoesNotAskTheOperator) { place_rail({}, true, kLine, 1, 1); }

}  // namespace
}  // namespace raywalk::capture
