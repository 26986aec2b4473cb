#include "render/serve/web_server.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "render/serve/file_reply.h"
#include "render/serve/test_client.h"

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
    EXPECT_THAT(
        reply_to_text(server.port(),
                      std::string(method) + " / HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"),
        AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("\r\nAllow: GET, HEAD\r\n")))
        << method;
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
  const std::string end = " HTTP/1.1\r\nHost: a\r\n";
  EXPECT_THAT(
      reply_to_text(server.port(), "GET /" + std::string(kConnectionMemory_bytes, 'a') + end),
      testing::Not(HasSubstr(" 200 ")));
  EXPECT_THAT(reply_to_text(server.port(),
                            "GET /" + end + "A: " + std::string(kConnectionMemory_bytes, 'b')),
              testing::Not(HasSubstr(" 200 ")));
  EXPECT_THAT(reply_to_text(server.port(), "GET / HTTP/1.1\r\n\r\n"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(reply_to_text(server.port(), "\x01\x02\r\n\r\n"), testing::Not(HasSubstr(" 200 ")));
}

TEST(WebServer, TurnsExceptionsIntoReplies) {
  const WebServer server(kHost, 0, [](const Request& request) -> Reply {
    if (request.path == "/a") throw HttpFault(422, "x is '\"\xff'");
    throw std::runtime_error("/home/secret");
  });
  const std::string end = " HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";
  const std::string refused = reply_to_text(server.port(), "GET /a" + end);
  EXPECT_THAT(refused, AllOf(StartsWith("HTTP/1.1 422 "), HasSubstr("application/json"),
                             EndsWith("{\"error\":\"x is '\\\"\xef\xbf\xbd'\"}\n")));
  const std::string failed = reply_to_text(server.port(), "GET /b" + end);
  EXPECT_THAT(failed, AllOf(StartsWith("HTTP/1.1 500 "), testing::Not(HasSubstr("secret"))));
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

}  // namespace
}  // namespace raywalk::render
