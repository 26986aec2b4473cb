// The server, the files that it sends, and the site of a room.
#include "render/serve/serve_room.h"

#include <gmock/gmock.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <future>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/view/test_room.h"
#include "render/serve/file_reply.h"
#include "render/serve/room_site.h"
#include "render/serve/test_client.h"
#include "render/serve/test_export.h"
#include "render/serve/web_server.h"

namespace raywalk::render {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

constexpr const char* kHost = "127.0.0.1";

Reply path_as_text(const Request& request) { return {.type = "text/plain", .body = request.path}; }

// The reply to the only request of a connection, such as "GET /a".
std::string reply_to(const WebServer& server, const std::string& request) {
  return reply_to_text(server.port(),
                       request + " HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
}

TEST(WebServer, AnswersRequestsOfOneConnection) {
  const WebServer server(kHost, 0, path_as_text);
  EXPECT_THAT(reply_to_text(server.port(),
                            "GET /a%20b?c=d HTTP/1.1\r\nHost: a\r\n\r\n"
                            "HEAD /abc HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"),
              AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), HasSubstr("Content-Security-Policy: "),
                    HasSubstr("\r\n\r\n/a bHTTP/1.1 200"), HasSubstr("Content-Length: 4"),
                    EndsWith("\r\n\r\n")));
}

TEST(WebServer, HandsOverWhatWasSent) {
  Request seen;
  const WebServer server(kHost, 0, [&](const Request& request) {
    seen = request;
    return Reply{};
  });
  reply_to_text(server.port(),
                "GET /a?x=-1.5&name=two+words%21&empty=&bare&x=2 HTTP/1.1\r\nHost: b\r\n"
                "RANGE: bytes=0-1\r\nCookie: c=d; e=f\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(seen.query,
            (std::multimap<std::string, std::string>{
                {"x", "-1.5"}, {"x", "2"}, {"name", "two words!"}, {"empty", ""}, {"bare", ""}}));
  EXPECT_EQ(value_of(seen.fields, "range"), "bytes=0-1");
  EXPECT_EQ(value_of(seen.cookies, "e"), "f");
}

TEST(WebServer, ServesGetAndHeadAlone) {
  const WebServer server(kHost, 0, path_as_text);
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "get", "PROPFIND"}) {
    EXPECT_THAT(reply_to(server, std::string(method) + " /"),
                AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("\r\nAllow: GET, HEAD\r\n")));
  }
  EXPECT_THAT(reply_to_text(server.port(),
                            "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\nsome body"),
              StartsWith("HTTP/1.1 405 "));
  EXPECT_THAT(reply_to_text(server.port(),
                            "GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\nsome body"),
              IsEmpty());
}

TEST(WebServer, RefusesWhatIsNoRequestOrTooLong) {
  const WebServer server(kHost, 0, path_as_text);
  const std::string end = " HTTP/1.1\r\nHost: a\r\n", long_text(kConnectionMemory_bytes, 'a');
  for (const std::string& request : {"GET /" + long_text + end, "GET /" + end + "A: " + long_text,
                                     std::string("\x01\x02\r\n\r\n")}) {
    EXPECT_THAT(reply_to_text(server.port(), request), testing::Not(HasSubstr(" 200 ")));
  }
  EXPECT_THAT(reply_to_text(server.port(), "GET / HTTP/1.1\r\n\r\n"), StartsWith("HTTP/1.1 400 "));
}

TEST(WebServer, TurnsExceptionsIntoReplies) {
  const WebServer server(kHost, 0, [](const Request& request) -> Reply {
    if (request.path == "/a") throw HttpFault(422, "x is '\"\xff'");
    throw std::runtime_error("/home/secret");
  });
  EXPECT_THAT(reply_to(server, "GET /a"),
              AllOf(StartsWith("HTTP/1.1 422 "), HasSubstr("application/json"),
                    EndsWith("{\"error\":\"x is '\\\"\xef\xbf\xbd'\"}\n")));
  EXPECT_THAT(reply_to(server, "GET /b"),
              AllOf(StartsWith("HTTP/1.1 500 "), testing::Not(HasSubstr("secret"))));
}

TEST(WebServer, SharesItsPortWithNobodyAndLeavesItFree) {
  int port = 0;
  {
    const WebServer server(kHost, 0, path_as_text);
    port = server.port();
    EXPECT_THAT([&] { WebServer(kHost, port, path_as_text); },
                ThrowsMessage<Error>(HasSubstr("in use")));
  }
  EXPECT_THROW(WebServer("203.0.113.1", 0, path_as_text), Error);  // of nobody, RFC 5737
  EXPECT_THROW(WebServer("no host", 0, path_as_text), Error);
  const WebServer again(kHost, port, path_as_text);
  EXPECT_EQ(again.port(), port);
}

TEST(WebServer, SilentClientsKeepNobodyWaitingAndAreLetGo) {
  const WebServer server(kHost, 0, path_as_text, 2);
  std::vector<std::future<std::string>> silent;
  silent.reserve(20);
  for (int i = 0; i < 20; ++i) {
    silent.push_back(
        std::async(std::launch::async, [&] { return reply_to_text(server.port(), "GET "); }));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(reply_to_text(server.port(), "GET / HTTP/1.0\r\nHost: a\r\n\r\n"),
              HasSubstr(" 200 "));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  for (std::future<std::string>& client : silent) {
    EXPECT_THAT(client.get(), testing::Not(HasSubstr(" 200 ")));
  }
}

TEST(WebServer, WaitsForTheHandlerWhenItStops) {
  std::promise<void> begun;
  std::atomic<bool> ended = false;
  std::future<std::string> client;
  {
    const WebServer server(kHost, 0, [&](const Request&) {
      begun.set_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      ended = true;
      return Reply{};
    });
    client = std::async(std::launch::async, [port = server.port()] {
      return reply_to_text(port, "GET / HTTP/1.1\r\nHost: a\r\n\r\n");
    });
    begun.get_future().wait();
  }
  EXPECT_TRUE(ended);
  client.wait();
}

using Fields = std::map<std::string, std::string>;

class FileReplyTest : public testing::Test {
 protected:
  FileReplyTest() { write_file_atomically(file_, "0123456789"); }

  Reply reply(const Fields& fields = {}) const {
    return file_reply(file_, "image/jpeg", {.fields = fields});
  }
  std::string etag() const { return reply().fields.at(0).second; }

  TestDirectory directory_;
  std::filesystem::path file_ = directory_ / "a.jpg";
};

TEST_F(FileReplyTest, IsTheFile) {
  const Reply whole = reply();
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.type, "image/jpeg");
  EXPECT_EQ(whole.body, "0123456789");
  EXPECT_THAT(whole.fields, Contains(Pair("Accept-Ranges", "bytes")));
  EXPECT_THAT(whole.fields, Contains(Pair("Cache-Control", "no-cache")));
}

TEST_F(FileReplyTest, IsAPart) {
  const Reply part = reply({{"range", "bytes=2-4"}});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "234");
  EXPECT_THAT(part.fields, Contains(Pair("Content-Range", "bytes 2-4/10")));
  for (const auto& [range, body] : {std::pair("bytes=-3", "789"),
                                    {"bytes=7-", "789"},
                                    {"bytes=-99", "0123456789"},
                                    {"bytes=9-999999999999999999", "9"}}) {
    EXPECT_EQ(reply({{"range", range}}).body, body) << range;
  }
  EXPECT_EQ(text_reply("{}\n", "a/b", {.fields = {{"range", "bytes=1-"}}}).body, "}\n");
}

TEST_F(FileReplyTest, RefusesPartsBehindTheEnd) {
  for (const char* range : {"bytes=10-", "bytes=999999999999999999-", "bytes=-0"}) {
    const Reply refused = reply({{"range", range}});
    EXPECT_EQ(refused.status, 416) << range;
    EXPECT_THAT(refused.fields, Contains(Pair("Content-Range", "bytes */10")));
  }
  write_file_atomically(file_, "");
  EXPECT_EQ(reply().status, 200);
  EXPECT_EQ(reply({{"range", "bytes=0-"}}).status, 416);
}

TEST_F(FileReplyTest, IgnoresOtherRanges) {
  for (const char* range : {"items=0-1", "bytes=4-2", "bytes=x", "bytes=-", "bytes=0-1,3-4",
                            "bytes=99999999999999999999999-"}) {
    const Reply whole = reply({{"range", range}});
    EXPECT_EQ(whole.status, 200) << range;
    EXPECT_EQ(whole.body.size(), 10U) << range;
  }
}

TEST_F(FileReplyTest, SaysWhenTheClientHasIt) {
  for (const std::string& tags : {etag(), "W/" + etag(), "\"a\", " + etag()}) {
    const Reply known = reply({{"if-none-match", tags}});
    EXPECT_EQ(known.status, 304) << tags;
    EXPECT_EQ(known.body, "");
  }
  EXPECT_EQ(reply({{"if-none-match", "\"a\""}}).status, 200);
  const std::string before = etag();
  EXPECT_EQ(reply({{"range", "bytes=0-1"}, {"if-range", before}}).body, "01");
  EXPECT_EQ(reply({{"range", "bytes=0-1"}, {"if-range", "\"a\""}}).body, "0123456789");
  write_file_atomically(file_, "9876543210");
  EXPECT_EQ(reply({{"if-none-match", before}}).body, "9876543210");
}

TEST_F(FileReplyTest, IsGoneWhenTheFileIs) {
  std::filesystem::remove(file_);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
  write_file_atomically(directory_ / "secret", "secret");
  std::filesystem::create_symlink(directory_ / "secret", file_);
  EXPECT_EQ(fault_of([&] { reply(); }), 404);
}

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
  // Until it could answer.
  void serve_briefly(const ServeOptions& options, const RoomExporter& exporter) const {
    serve_room(room_.room(), options, exporter, [] { return true; });
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
  const RoomExporter fail = [&](const std::filesystem::path& folder) {
    exported = folder;
    write_test_export(folder);
    throw Error("disk full");
  };
  EXPECT_THAT([&] { serve_briefly({.port = 0}, fail); },
              ThrowsMessage<Error>(HasSubstr("disk full")));
  EXPECT_FALSE(std::filesystem::exists(exported.parent_path()));
}

TEST_F(ServeRoomTest, ExportsNothingForAPortInUse) {
  const WebServer other("127.0.0.1", 0, [](const Request&) { return Reply{}; });
  const RoomExporter unexpected = [](const auto&) { ADD_FAILURE() << "exported"; };
  EXPECT_THAT([&] { serve_briefly({.port = other.port()}, unexpected); },
              ThrowsMessage<Error>(HasSubstr("in use")));
}

TEST_F(ServeRoomTest, PrintsItsAddress) {
  write_test_export(directory_ / "web");
  const auto printed = [&](const std::string& host) {
    testing::internal::CaptureStdout();
    serve_briefly({.exported = directory_ / "web", .host = host, .port = 0}, {});
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
  for (const std::string& path : std::vector<std::string>{
           "", "index.html", "/notes.txt", "/link.jpg", "/other/a.jpg", "/../secret.jpg",
           "/stations/../../secret.jpg", "/%2e%2e/secret.jpg", "/..\\secret.jpg", "/stations/",
           "/stations", "//index.html", "/./index.html", absolute, "/" + absolute,
           "file://" + absolute, "/index.html/", "/INDEX.HTML", "*"}) {
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
