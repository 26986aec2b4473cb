#include "render/serve/room_site.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <future>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/files/test_directory.h"
#include "core/http/web_server.h"
#include "core/view/test_room.h"
#include "render/serve/test_export.h"

namespace raywalk::render {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kLoopback = "127.0.0.1";

// A room served on loopback. `host` decides who may use it, as if the server listened there.
class ServedRoom {
 public:
  explicit ServedRoom(const Room& room, const std::string& host = kLoopback)
      : site_(room, exported(), host),
        server_(kLoopback, 0, [this](const RequestHead& head) { return site_.answer(head); }) {
    server_.start();
  }

  RoomSite& site() { return site_; }
  WebServer& server() { return server_; }
  std::filesystem::path folder() const { return directory_ / "web"; }

  httplib::Client client() const {
    httplib::Client client(kLoopback, server_.port());
    client.set_read_timeout(std::chrono::minutes(2));  // sanitizers render slowly
    return client;
  }

  // The reply to a request that httplib would not send.
  std::string raw(const std::string& target, const std::string& method = "GET") const {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(server_.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    const std::string head =
        method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    EXPECT_EQ(send(socket, head.data(), head.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(head.size()));
    std::string reply;
    char bytes[4096];
    for (ssize_t count = 0; (count = recv(socket, bytes, sizeof(bytes), 0)) > 0;) {
      reply.append(bytes, static_cast<std::size_t>(count));
    }
    close(socket);
    return reply;
  }

 private:
  std::filesystem::path exported() const {
    write_test_export(folder());
    return folder();
  }

  TestDirectory directory_;
  RoomSite site_;
  WebServer server_;
};

class RoomSiteTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { test_room_ = new TestRoom(box_room(128)); }
  static void TearDownTestSuite() { delete test_room_; }
  static const Room& room() { return test_room_->room(); }

  static TestRoom* test_room_;
};
TestRoom* RoomSiteTest::test_room_ = nullptr;

TEST_F(RoomSiteTest, ServesTheFilesOfTheExport) {
  const ServedRoom served(room());
  httplib::Client client = served.client();
  client.set_keep_alive(true);
  for (const auto& [name, content] : test_files()) {
    const auto reply = client.Get("/" + name);
    ASSERT_TRUE(reply) << name;
    EXPECT_EQ(reply->status, 200) << name;
    EXPECT_EQ(reply->body, content) << name;
    EXPECT_EQ(reply->get_header_value("X-Content-Type-Options"), "nosniff");
    const auto head = client.Head("/" + name);
    ASSERT_TRUE(head) << name;
    EXPECT_EQ(head->get_header_value("Content-Length"), std::to_string(content.size()));
  }
  EXPECT_EQ(client.Get("/?x=0.5&yaw=30")->body, test_files().at("index.html"));
  const auto manifest = nlohmann::json::parse(client.Get("/manifest.json")->body);
  EXPECT_EQ(manifest.at("engine").at("view"), "view");
}

TEST_F(RoomSiteTest, ServesPartsOfFiles) {
  const ServedRoom served(room());
  const auto part = served.client().Get("/stations/0000.omega",
                                        {{"Range", "bytes=10-19"}, {"Accept-Encoding", "gzip"}});
  ASSERT_TRUE(part);
  EXPECT_EQ(part->status, 206);
  EXPECT_EQ(part->body, test_files().at("stations/0000.omega").substr(10, 10));
  EXPECT_EQ(part->get_header_value("Content-Range"), "bytes 10-19/256");
  EXPECT_EQ(served.client().Get("/stations/0000.omega", {{"Range", "bytes=256-"}})->status, 416);
}

TEST_F(RoomSiteTest, ServesNothingElse) {
  const ServedRoom served(room());
  write_file_atomically(served.folder() / "notes.txt", "secret");
  write_file_atomically(served.folder().parent_path() / "secret.jpg", "secret");
  const std::string absolute = (served.folder() / "notes.txt").string();
  for (const std::string& target : std::initializer_list<std::string>{"/notes.txt",
                                                                      "/../secret.jpg",
                                                                      "/stations/../../secret.jpg",
                                                                      "/%2e%2e/secret.jpg",
                                                                      "/%252e%252e/secret.jpg",
                                                                      "/..%2fsecret.jpg",
                                                                      "/..%5csecret.jpg",
                                                                      "/..\\secret.jpg",
                                                                      "/stations/0000.jpg%00.html",
                                                                      "/stations/",
                                                                      "/stations",
                                                                      "//index.html",
                                                                      "/./index.html",
                                                                      absolute,
                                                                      "/" + absolute,
                                                                      "http://localhost/index.html",
                                                                      "file://" + absolute,
                                                                      "/index.html/",
                                                                      "/index.html%20",
                                                                      "*",
                                                                      "/INDEX.HTML"}) {
    const std::string reply = served.raw(target);
    EXPECT_THAT(reply, testing::AnyOf(StartsWith("HTTP/1.1 404 "), StartsWith("HTTP/1.1 400 ")))
        << target;
    EXPECT_THAT(reply, testing::Not(HasSubstr("secret"))) << target;
  }
  EXPECT_THAT(served.raw("/notes.txt"), HasSubstr("{\"error\":\"there is no such file here\"}"));
}

TEST_F(RoomSiteTest, ServesGetAndHeadAlone) {
  const ServedRoom served(room());
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "get", "PROPFIND"}) {
    EXPECT_THAT(served.raw("/index.html", method),
                AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("\r\nAllow: GET, HEAD\r\n")))
        << method;
  }
  EXPECT_EQ(served.client().Post("/index.html", "body", "text/plain")->status, 413);
}

TEST_F(RoomSiteTest, AnswersToItsOwnNameAlone) {
  const ServedRoom served(room());
  EXPECT_EQ(served.client().Get("/index.html", {{"Host", "localhost:1"}})->status, 200);
  const auto rebound = served.client().Get("/index.html", {{"Host", "evil.org"}});
  EXPECT_EQ(rebound->status, 421);
  EXPECT_THAT(rebound->body, testing::Not(HasSubstr("DOCTYPE")));
}

TEST_F(RoomSiteTest, GivesACookieForTheToken) {
  ServedRoom served(room(), "0.0.0.0");
  const std::string token = *served.site().access().token();
  for (const char* path : {"/", "/manifest.json", "/view?x=0&z=0", "/nothing"}) {
    EXPECT_EQ(served.client().Get(path)->status, 401) << path;
  }
  EXPECT_EQ(served.client().Get("/?token=" + std::string(32, '0'))->status, 401);
  const auto first = served.client().Get("/?yaw=30&token=" + token);
  ASSERT_EQ(first->status, 303);
  EXPECT_EQ(first->get_header_value("Location"), "/?yaw=30");
  const std::string cookie = first->get_header_value("Set-Cookie");
  EXPECT_THAT(cookie, AllOf(HasSubstr("HttpOnly"), HasSubstr("SameSite=Strict")));
  const httplib::Headers with_cookie{{"Cookie", cookie.substr(0, cookie.find(';'))}};
  for (const char* path : {"/", "/manifest.json", "/view?x=0&z=0&width=32"}) {
    EXPECT_EQ(served.client().Get(path, with_cookie)->status, 200) << path;
  }
}

TEST_F(RoomSiteTest, RendersViews) {
  const ServedRoom served(room());
  const auto reply =
      served.client().Get("/view?x=0.1&z=0.2&yaw=20&fov=90&width=80&height=60&format=png");
  ASSERT_EQ(reply->status, 200);
  ViewOptions options = default_options();
  options.generation = Generation::kTwoSided;
  options.k_deg = 90.0;
  Renderer renderer(room(), options);
  const cv::Mat expected =
      render_framed(&renderer, {0.1, 0.2}, {.yaw_deg = 20.0, .fov_deg = 90.0, .size = "80x60"})
          .image;
  const std::vector<unsigned char> bytes(reply->body.begin(), reply->body.end());
  EXPECT_EQ(largest_difference(cv::imdecode(bytes, cv::IMREAD_COLOR), expected), 0.0);
  EXPECT_THAT(reply->get_header_value("X-Raywalk-View"), StartsWith("two-sided"));

  const auto outside = served.client().Get("/view?x=50&z=0");
  EXPECT_EQ(outside->status, 422);
  EXPECT_THAT(nlohmann::json::parse(outside->body).at("error").get<std::string>(),
              HasSubstr("outside"));
  const auto wrong = served.client().Get("/view?x=nan&z=0");
  EXPECT_EQ(wrong->status, 400);
  EXPECT_EQ(wrong->get_header_value("Content-Type"), "application/json");
  EXPECT_THAT(nlohmann::json::parse(wrong->body).at("error").get<std::string>(),
              StartsWith("x is"));
}

TEST_F(RoomSiteTest, RefusesViewsWhenTooManyWait) {
  const ServedRoom served(room());
  std::vector<std::future<int>> statuses;
  for (int i = 0; i < 16; ++i) {
    statuses.push_back(std::async(std::launch::async, [&] {
      const auto reply = served.client().Get("/view?x=0&z=0&width=1024");
      return reply ? reply->status : 0;
    }));
  }
  int rendered = 0;
  int refused = 0;
  for (std::future<int>& status : statuses) {
    const int value = status.get();
    EXPECT_THAT(value, testing::AnyOf(200, 503));
    (value == 200 ? rendered : refused)++;
  }
  EXPECT_GE(rendered, 1 + kMostWaitingViews);
  EXPECT_GT(refused, 0);
}

TEST_F(RoomSiteTest, StopsWhileRendering) {
  ServedRoom served(room());
  std::vector<std::future<bool>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(std::async(
        std::launch::async, [&] { return bool(served.client().Get("/view?x=0&z=0&width=2048")); }));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  served.site().stop();
  served.server().stop();
  for (std::future<bool>& client : clients) client.wait();
}

}  // namespace
}  // namespace raywalk::render
