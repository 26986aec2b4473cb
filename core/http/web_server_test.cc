#include "core/http/web_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "core/base/error.h"

namespace raywalk {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kHost = "127.0.0.1";

Reply target_as_text(const RequestHead& head) {
  return {.type = "text/plain", .body = head.target};
}

TEST(WebServer, AnswersAClient) {
  WebServer server(kHost, 0, target_as_text);
  server.start();
  httplib::Client client(kHost, server.port());
  client.set_keep_alive(true);
  for (const char* path : {"/", "/a?b=c"}) {
    const auto reply = client.Get(path);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, 200);
    EXPECT_EQ(reply->body, path);
  }
}

TEST(WebServer, SharesItsPortWithNobody) {
  const WebServer server(kHost, 0, target_as_text);
  EXPECT_THAT([&] { WebServer(kHost, server.port(), target_as_text); },
              ThrowsMessage<Error>(HasSubstr("in use")));
  EXPECT_THROW(WebServer("203.0.113.1", 0, target_as_text), Error);  // of nobody, RFC 5737
}

TEST(WebServer, LeavesItsPortFree) {
  WebServer server(kHost, 0, target_as_text);
  server.start();
  httplib::Client client(kHost, server.port());
  ASSERT_TRUE(client.Get("/"));
  server.stop();
  server.stop();
  EXPECT_FALSE(client.Get("/"));
  WebServer(kHost, server.port(), target_as_text).start();
}

TEST(WebServer, SlowClientsKeepNobodyWaiting) {
  WebServer server(kHost, 0, target_as_text);
  server.start();
  // Clients that begin a request and fall silent.
  std::vector<int> sockets;
  for (int i = 0; i < 20; ++i) {
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    ASSERT_EQ(send(socket, "GET ", 4, MSG_NOSIGNAL), 4);
    sockets.push_back(socket);
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(httplib::Client(kHost, server.port()).Get("/"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
  for (const int socket : sockets) close(socket);
}

TEST(WebServer, WaitsForTheHandlerWhenItStops) {
  std::promise<void> begun;
  std::atomic<bool> ended = false;
  WebServer server(kHost, 0, [&](const RequestHead&) {
    begun.set_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ended = true;
    return Reply{};
  });
  server.start();
  auto client = std::async(std::launch::async,
                           [&] { return bool(httplib::Client(kHost, server.port()).Get("/")); });
  begun.get_future().wait();
  server.stop();
  EXPECT_TRUE(ended);
  client.wait();
}

}  // namespace
}  // namespace raywalk
