#include "render/serve/serve_room.h"

#include <gmock/gmock.h>
#include <httplib.h>

#include <atomic>
#include <future>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/test_directory.h"
#include "core/view/test_room.h"
#include "render/serve/room_site.h"
#include "render/serve/test_client.h"
#include "render/serve/test_export.h"
#include "render/serve/web_server.h"

namespace raywalk::render {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::ThrowsMessage;

// A port that was free a moment ago.
int free_port() {
  return WebServer("127.0.0.1", 0, [](const Request&) { return Reply{}; }).port();
}

class ServeRoomTest : public testing::Test {
 protected:
  // Until stopped_ is set; the page is there within a few seconds.
  std::future<void> serve(const ServeOptions& options, const RoomExporter& exporter) {
    return std::async(std::launch::async, [this, options, exporter] {
      serve_room(room_.room(), options, exporter, [this] { return stopped_.load(); });
    });
  }
  static bool answers(int port) {
    for (int i = 0; i < 300; ++i) {
      const auto reply = httplib::Client("127.0.0.1", port).Get("/");
      if (reply && reply->status == 200) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  TestRoom room_{box_room(64)};
  TestDirectory directory_;
  std::atomic<bool> stopped_ = false;
};

TEST_F(ServeRoomTest, ExportsForTheTimeOfServing) {
  std::filesystem::path exported;
  const int port = free_port();
  auto serving = serve({.port = port}, [&](const std::filesystem::path& folder) {
    EXPECT_FALSE(std::filesystem::exists(folder));
    write_test_export(folder);
    exported = folder;
  });
  EXPECT_TRUE(answers(port));
  EXPECT_TRUE(std::filesystem::exists(exported / "index.html"));
  // Nobody else reads it.
  EXPECT_EQ(std::filesystem::status(exported.parent_path()).permissions(),
            std::filesystem::perms::owner_all);
  stopped_ = true;
  serving.get();
  EXPECT_FALSE(std::filesystem::exists(exported.parent_path()));
}

TEST_F(ServeRoomTest, LeavesNothingBehindAfterAnError) {
  std::filesystem::path exported;
  EXPECT_THAT(
      [&] {
        serve_room(
            room_.room(), {.port = 0},
            [&](const std::filesystem::path& folder) {
              exported = folder;
              write_test_export(folder);
              throw Error("disk full");
            },
            [] { return true; });
      },
      ThrowsMessage<Error>(HasSubstr("disk full")));
  EXPECT_FALSE(std::filesystem::exists(exported.parent_path()));
}

TEST_F(ServeRoomTest, ExportsNothingForAPortInUse) {
  const WebServer other("127.0.0.1", 0, [](const Request&) { return Reply{}; });
  EXPECT_THAT(
      [&] {
        serve_room(
            room_.room(), {.port = other.port()}, [](const auto&) { ADD_FAILURE() << "exported"; },
            [] { return true; });
      },
      ThrowsMessage<Error>(HasSubstr("in use")));
}

TEST_F(ServeRoomTest, PrintsItsAddress) {
  write_test_export(directory_ / "web");
  const auto printed = [&](const std::string& host) {
    testing::internal::CaptureStdout();
    serve_room(
        room_.room(), {.exported = directory_ / "web", .host = host, .port = 0}, [](const auto&) {},
        [] { return true; });
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_THAT(printed("127.0.0.1"), testing::MatchesRegex("http://127.0.0.1:[0-9]+/\n"));
  EXPECT_THAT(printed("0.0.0.0"),
              testing::MatchesRegex("http://0.0.0.0:[0-9]+/\\?token=[0-9a-f]+\nfrom another .*\n"));
}

class RoomSiteTest : public testing::Test {
 protected:
  RoomSiteTest() { write_test_export(folder()); }

  std::filesystem::path folder() const { return directory_ / "web"; }
  void expect_refusal(const std::string& message) const {
    EXPECT_THAT([this] { RoomSite(room_.room(), folder(), "127.0.0.1"); },
                ThrowsMessage<Error>(HasSubstr(message)));
  }
  // As a browser on this machine asks.
  Reply get(const std::string& path) const {
    return RoomSite(room_.room(), folder(), "127.0.0.1")
        .answer({.path = path, .fields = {{"host", "localhost:8360"}}});
  }
  static int status(RoomSite* site, const Request& request) {
    int status = 0;
    const int fault = fault_of([&] { status = site->answer(request).status; });
    return fault == 0 ? status : fault;
  }

  TestRoom room_{box_room(64)};
  TestDirectory directory_;
};

TEST_F(RoomSiteTest, ServesTheFilesOfTheExport) {
  for (const auto& [name, content] : test_files()) EXPECT_EQ(get("/" + name).body, content) << name;
  EXPECT_EQ(get("/").body, test_files().at("index.html"));
  EXPECT_EQ(get("/").type, "text/html; charset=utf-8");
  EXPECT_EQ(get("/viewer.js").type, "text/javascript; charset=utf-8");
  EXPECT_EQ(get("/stations/0000.jpg").type, "image/jpeg");
  EXPECT_EQ(get("/stations/0000.inverse").type, "application/octet-stream");
  auto manifest = nlohmann::ordered_json::parse(get("/manifest.json").body);
  EXPECT_EQ(manifest.at("engine"), nlohmann::ordered_json({{"view", "view"}}));
  manifest.erase("engine");
  EXPECT_EQ(manifest, test_manifest());
}

TEST_F(RoomSiteTest, ServesNothingElse) {
  write_file_atomically(folder() / "notes.txt", "secret");
  write_file_atomically(directory_ / "secret.jpg", "secret");
  std::filesystem::create_directory(directory_ / "other");
  write_file_atomically(directory_ / "other/a.jpg", "secret");
  std::filesystem::create_symlink("../secret.jpg", folder() / "link.jpg");
  std::filesystem::create_directory_symlink(directory_ / "other", folder() / "other");
  const std::string absolute = (directory_ / "secret.jpg").string();
  for (const std::string& path :
       {std::string(), std::string("index.html"), std::string("/notes.txt"),
        std::string("/link.jpg"), std::string("/other/a.jpg"), std::string("/../secret.jpg"),
        std::string("/stations/../../secret.jpg"), std::string("/%2e%2e/secret.jpg"),
        std::string("/..\\secret.jpg"), std::string("/stations/"), std::string("/stations"),
        std::string("//index.html"), std::string("/./index.html"), absolute, "/" + absolute,
        "file://" + absolute, std::string("/index.html/"), std::string("/INDEX.HTML"),
        std::string("*")}) {
    EXPECT_EQ(fault_of([&] { get(path); }), 404) << path;
  }
}

TEST_F(RoomSiteTest, NeedsAnExport) {
  std::filesystem::remove(folder() / "viewer.css");
  expect_refusal("viewer.css is missing");
  for (const auto& [key, value] :
       {std::pair("format", nlohmann::json("other")), {"version", 2}, {"version", "1"}}) {
    auto manifest = test_manifest();
    manifest[key] = value;
    write_file_atomically(folder() / "manifest.json", json_text(manifest));
    expect_refusal(key);
  }
  write_file_atomically(folder() / "manifest.json", "{");
  expect_refusal("manifest.json");
  std::filesystem::remove(folder() / "manifest.json");
  expect_refusal("holds no exported room");
}

TEST_F(RoomSiteTest, OnLoopbackAnswersToItsOwnNames) {
  RoomSite site(room_.room(), folder(), "127.0.0.1");
  EXPECT_EQ(site.token(), "");
  const auto status_for = [&](const std::string& host) {
    return status(&site, {.path = "/", .fields = {{"host", host}}});
  };
  for (const char* host : {"localhost", "LocalHost:8360", "127.0.0.1:1", "[::1]", "[::1]:8360"}) {
    EXPECT_EQ(status_for(host), 200) << host;
  }
  for (const char* host : {"", "evil.org", "evil.org:8360", "localhost.evil.org", "192.168.0.1",
                           "127.0.0.1.evil.org", "[::2]", "["}) {
    EXPECT_EQ(status_for(host), 421) << host;
  }
}

TEST_F(RoomSiteTest, ElsewhereTurnsTheTokenIntoACookie) {
  RoomSite site(room_.room(), folder(), "0.0.0.0");
  const std::string token = site.token();
  EXPECT_THAT(token, testing::MatchesRegex("[0-9a-f]{32}"));
  EXPECT_NE(token, RoomSite(room_.room(), folder(), "::").token());
  for (const char* path : {"/", "/manifest.json", "/view", "/nothing"}) {
    EXPECT_EQ(status(&site, {.path = path, .fields = {{"host", "localhost"}}}), 401) << path;
  }
  for (const std::string& wrong : {std::string(), token + "0", std::string(32, '0')}) {
    EXPECT_EQ(status(&site, {.path = "/", .query = {{"token", wrong}}}), 401);
    EXPECT_EQ(status(&site, {.path = "/", .cookies = {{"raywalk_token", wrong}}}), 401);
  }
  const Reply first = site.answer(
      {.path = "/", .query = {{"kiosk", ""}, {"start", "0.2,-1\r\n"}, {"token", token}}});
  EXPECT_EQ(first.status, 303);
  EXPECT_THAT(first.fields, Contains(Pair("Location", "/?kiosk=&start=0.2%2C-1%0D%0A")));
  EXPECT_THAT(first.fields,
              Contains(Pair("Set-Cookie",
                            "raywalk_token=" + token + "; HttpOnly; SameSite=Strict; Path=/")));
  EXPECT_EQ(status(&site, {.path = "/", .cookies = {{"raywalk_token", token}}}), 200);
}

}  // namespace
}  // namespace raywalk::render
