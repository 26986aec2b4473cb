#include "core/http/client_connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <string>
#include <thread>

namespace raywalk {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr const char* kGet = "GET /a HTTP/1.1\r\nHost: a\r\n\r\n";
constexpr const char* kLastGet = "GET /b HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n";

// The client's end of a connection that is served by a thread.
class ServedConnection {
 public:
  explicit ServedConnection(RequestHandler handler, const ConnectionTimes& times = {})
      : handler_(std::move(handler)), times_(times) {
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends_.data()), 0);
    thread_ = std::thread([this] {
      serve_connection(ends_[1], times_, handler_, [this] { return stopping_.load(); });
    });
  }
  ~ServedConnection() {
    close(ends_[0]);
    thread_.join();
  }

  void send_text(std::string_view text) const {
    EXPECT_EQ(send(ends_[0], text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  // All that comes until the server closes.
  std::string received() const {
    std::string text;
    std::array<char, 4096> bytes{};
    for (ssize_t count = 0; (count = recv(ends_[0], bytes.data(), bytes.size(), 0)) > 0;) {
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return text;
  }
  void stop() { stopping_ = true; }

 private:
  RequestHandler handler_;
  ConnectionTimes times_;
  std::array<int, 2> ends_{};
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

Reply echo(const RequestHead& head) { return {.type = "text/plain", .body = head.target + "."}; }

TEST(ClientConnection, AnswersOneRequestAfterTheOther) {
  const ServedConnection connection(echo);
  connection.send_text(std::string("\r\n") + kGet + "\r\n" + kLastGet + kGet);
  const std::string text = connection.received();
  EXPECT_THAT(text, AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), HasSubstr("\r\n\r\n/a.HTTP/1.1 200"),
                          HasSubstr("Connection: close"), EndsWith("\r\n\r\n/b.")));
}

TEST(ClientConnection, ReadsRequestsThatArriveInPieces) {
  const ServedConnection connection(echo);
  for (const char* c = kLastGet; *c != '\0'; ++c) connection.send_text({c, 1});
  EXPECT_THAT(connection.received(), EndsWith("/b."));
}

TEST(ClientConnection, OmitsTheBodyForHead) {
  const ServedConnection connection(echo);
  connection.send_text("HEAD /abc HTTP/1.0\r\n\r\n");
  EXPECT_THAT(connection.received(),
              AllOf(HasSubstr("Content-Length: 5\r\n"), EndsWith("\r\n\r\n")));
}

TEST(ClientConnection, ClosesAfterWhatItCannotRead) {
  const ServedConnection connection(echo);
  connection.send_text(std::string("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 70\r\n\r\n") +
                       kGet);
  EXPECT_THAT(connection.received(), AllOf(StartsWith("HTTP/1.1 413 "), EndsWith("accepted\"}\n")));
}

TEST(ClientConnection, ReadsNoEndlessRequest) {
  {
    const ServedConnection connection(echo);
    connection.send_text("GET /" + std::string(kMostRequestLine + 1, 'a'));
    EXPECT_THAT(connection.received(), StartsWith("HTTP/1.1 414 "));
  }
  const ServedConnection connection(echo);
  connection.send_text("GET / HTTP/1.1\r\nA: " + std::string(kMostRequestHead, 'b'));
  EXPECT_THAT(connection.received(), StartsWith("HTTP/1.1 431 "));
}

TEST(ClientConnection, WaitsOnlyAWhile) {
  {
    const ServedConnection silent(echo, {.idle = milliseconds(20)});
    EXPECT_THAT(silent.received(), IsEmpty());
  }
  const ServedConnection slow(echo, {.head = milliseconds(20)});
  slow.send_text("GET / HT");
  EXPECT_THAT(slow.received(), StartsWith("HTTP/1.1 408 "));
}

TEST(ClientConnection, GivesUpWhereNobodyReads) {
  const auto large = [](const RequestHead&) { return Reply{.body = std::string(8 << 20, 'x')}; };
  const ServedConnection connection(large, {.reply = milliseconds(50)});
  connection.send_text(kGet);
  std::this_thread::sleep_for(milliseconds(150));
  EXPECT_LT(connection.received().size(), std::size_t{8} << 20);
}

TEST(ClientConnection, StopsWhenAsked) {
  ServedConnection connection(echo, {.idle = std::chrono::hours(1)});
  connection.stop();
  EXPECT_THAT(connection.received(), IsEmpty());
}

TEST(ClientConnection, TurnsExceptionsIntoReplies) {
  const ServedConnection connection([](const RequestHead& head) -> Reply {
    if (head.target == "/a") throw HttpFault(422, "no");
    throw std::runtime_error("/home/secret");
  });
  connection.send_text(std::string(kGet) + kLastGet);
  const std::string text = connection.received();
  EXPECT_THAT(text, AllOf(StartsWith("HTTP/1.1 422 "), HasSubstr("HTTP/1.1 500 ")));
  EXPECT_EQ(text.find("secret"), std::string::npos);
}

}  // namespace
}  // namespace raywalk
