#include "simulator/rig/osc_server.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

class OscServerTest : public testing::Test {
 protected:
  OscServerTest()
      : camera_(settings(), clock_, [](const ExposureNow&) { return std::string("a picture"); }),
        server_(camera_, 0),
        client_(server_.url()) {
    server_.on_post("/rig/echo", [](const std::string& body) {
      if (body.empty()) throw Error("nothing to echo");
      return body;
    });
    server_.start();
    client_.set_read_timeout(std::chrono::milliseconds(200));
  }

  SimulatedCameraSettings settings() const {
    SimulatedCameraSettings settings;
    settings.card_directory = directory_ / "card";
    settings.frame = {64, 32};
    return settings;
  }

  httplib::Result post(const std::string& path, const Json& body) {
    return client_.Post(path, body.dump(), "application/json");
  }

  Json execute(const std::string& name, const Json& parameters) {
    const auto reply = post("/osc/commands/execute", {{"name", name}, {"parameters", parameters}});
    return reply ? Json::parse(reply->body) : Json();
  }

  TestDirectory directory_;
  ManualClock clock_;
  SimulatedCamera camera_;
  OscServer server_;
  httplib::Client client_;
};

TEST_F(OscServerTest, TakesListsFetchesAndDeletesAPicture) {
  const Json begun = execute("camera.takePicture", Json::object());
  EXPECT_EQ(begun.at("state"), "inProgress");
  clock_.sleep(duration_from_ms(200.0));
  const auto done = post("/osc/commands/status", {{"id", begun.at("id")}});
  ASSERT_TRUE(done);
  const std::string url = Json::parse(done->body).at("results").at("fileUrl");
  EXPECT_EQ(url, server_.url() + "/files/R0010001.JPG");
  const auto file = client_.Get("/files/R0010001.JPG");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->body, "a picture");
  const Json list = execute("camera.listFiles", {{"fileType", "image"}, {"entryCount", 5}});
  EXPECT_EQ(list.at("results").at("entries").at(0).at("fileUrl"), url);
  EXPECT_EQ(execute("camera.delete", {{"fileUrls", {url}}}).at("state"), "done");
  EXPECT_EQ(client_.Get("/files/R0010001.JPG")->status, 404);
}

TEST_F(OscServerTest, RefusesAsTheApiDocuments) {
  const auto unknown = post("/osc/commands/execute", {{"name", "camera.explode"}});
  EXPECT_EQ(unknown->status, 400);
  EXPECT_EQ(Json::parse(unknown->body).at("error").at("code"), "unknownCommand");
  EXPECT_EQ(
      execute("camera.getOptions", {{"optionNames", {"iso", "_none"}}}).at("error").at("code"),
      "invalidParameterName");
  EXPECT_EQ(execute("camera.setOptions", Json::object()).at("error").at("code"),
            "missingParameter");
  EXPECT_EQ(execute("camera.setOptions", {{"options", {{"iso", "many"}}}}).at("error").at("code"),
            "invalidParameterValue");
  execute("camera.takePicture", Json::object());
  const auto busy = post("/osc/commands/execute", {{"name", "camera.takePicture"}});
  EXPECT_EQ(busy->status, 403);
  EXPECT_EQ(client_.Post("/osc/commands/execute", "no JSON", "text/plain")->status, 400);
}

TEST_F(OscServerTest, AdditionalHandlersAreServed) {
  EXPECT_EQ(client_.Post("/rig/echo", "{\"line\":\"x0\"}", "application/json")->body,
            "{\"line\":\"x0\"}");
  const auto refused = client_.Post("/rig/echo", "", "application/json");
  EXPECT_EQ(refused->status, 400);
  EXPECT_EQ(Json::parse(refused->body).at("error").at("message"), "nothing to echo");
}

TEST_F(OscServerTest, ASilentCameraExecutesTheRequestWithoutAReply) {
  camera_.faults().inject(CameraFault::kSilent);
  EXPECT_FALSE(post("/osc/commands/execute", {{"name", "camera.takePicture"}}));
  EXPECT_EQ(camera_.pictures_taken(), 1U);
  EXPECT_TRUE(client_.Get("/osc/info"));
}

TEST_F(OscServerTest, WhileDownThePortIsClosed) {
  camera_.faults().inject(CameraFault::kDown, 60000.0);
  EXPECT_FALSE(client_.Get("/osc/info"));
  httplib::Result reply = client_.Get("/osc/info");
  EXPECT_FALSE(reply);
  clock_.sleep(std::chrono::minutes(2));
  for (int attempt = 0; attempt < 1000 && !reply; ++attempt) {
    reply = client_.Get("/osc/info");
    if (!reply) SystemClock().sleep(duration_from_ms(5.0));
  }
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 200);
}

TEST_F(OscServerTest, CanBeStoppedWithAWaitingClientAndRestarted) {
  camera_.faults().inject(CameraFault::kSilent);
  EXPECT_FALSE(client_.Get("/osc/info"));
  server_.stop();
  EXPECT_FALSE(client_.Get("/osc/info"));
  server_.start();
  EXPECT_TRUE(client_.Get("/osc/info"));
}

// A connection that sends the beginning of a request and then nothing.
class SilentClient {
 public:
  SilentClient(int port, const std::string& begun) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(send(socket_, begun.data(), begun.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(begun.size()));
  }
  ~SilentClient() { close(socket_); }
  SilentClient(const SilentClient&) = delete;
  SilentClient& operator=(const SilentClient&) = delete;

  // Neither answered nor disconnected by the server.
  bool is_waiting() const {
    char byte = 0;
    return recv(socket_, &byte, 1, MSG_DONTWAIT) == -1 && errno == EAGAIN;
  }

 private:
  int socket_;
};

TEST_F(OscServerTest, SilentClientsKeepNobodyWaiting) {
  std::vector<std::unique_ptr<SilentClient>> silent;
  for (const char* begun :
       {"", "GET /osc/in", "POST /osc/state HTTP/1.1\r\nContent-Length: 9\r\n\r\n"}) {
    for (int i = 0; i < 12; ++i) {
      silent.push_back(std::make_unique<SilentClient>(server_.port(), begun));
    }
  }
  client_.set_read_timeout(std::chrono::minutes(1));
  EXPECT_TRUE(client_.Get("/osc/info"));
  // Those whose request has begun: none had to time out first.
  for (std::size_t i = 12; i < silent.size(); ++i) EXPECT_TRUE(silent[i]->is_waiting()) << i;
}

TEST_F(OscServerTest, PortInUseIsAnError) {
  EXPECT_THROW(OscServer(camera_, server_.port()), Error);
}

}  // namespace
}  // namespace raywalk::capture
