#include "capture/camera/osc_http.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <functional>
#include <stdexcept>
#include <thread>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/camera/osc_client.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::HasSubstr;
using testing::Not;

// A TCP server that runs the test's script on each connection after a request.
class RawServer {
 public:
  using Act = std::function<void(int socket, const std::atomic<bool>& ending)>;

  explicit RawServer(Act act) : act_(std::move(act)), socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(socket_, 8) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no loopback");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~RawServer() {
    ending_ = true;
    thread_.join();
    close(socket_);
  }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  static bool readable(int socket) {
    pollfd entry{socket, POLLIN, 0};
    return poll(&entry, 1, 10) > 0;
  }

  void serve() {
    while (!ending_) {
      if (!readable(socket_)) continue;
      const int client = accept(socket_, nullptr, nullptr);
      while (!ending_ && !readable(client)) {
      }
      std::array<char, 4096> request{};
      if (recv(client, request.data(), request.size(), 0) > 0) act_(client, ending_);
      close(client);
    }
  }

  Act act_;
  int socket_;
  int port_ = 0;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

void send_text(int socket, const std::string& text) {
  send(socket, text.data(), text.size(), MSG_NOSIGNAL);
}

RawServer::Act says(const std::string& text) {
  return [text](int socket, const std::atomic<bool>&) { send_text(socket, text); };
}

std::string http(const std::string& status, const std::string& type, const std::string& body) {
  return "HTTP/1.1 " + status + "\r\nContent-Type: " + type +
         "\r\nContent-Length: " + std::to_string(body.size()) + "\r\nConnection: close\r\n\r\n" +
         body;
}

OscConfig config_of(const RawServer& server) {
  OscConfig config;
  config.url = server.url();
  config.connect_timeout_ms = 200.0;
  config.picture_timeout_ms = 500.0;
  return config;
}

// The message of the fault when a client requests the camera's info from such a server.
std::string fault_of(FaultKind kind, RawServer::Act act) {
  RawServer server(std::move(act));
  ManualClock clock;
  OscClient client(config_of(server), clock);
  try {
    client.info();
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(name_of(fault.kind()), name_of(kind));
    EXPECT_THAT(fault.what(), HasSubstr(server.url() + "/osc/info: "));
    EXPECT_THAT(fault.what(), HasSubstr("; "));
    EXPECT_THAT(fault.what(), Not(HasSubstr("\n")));
    return fault.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

TEST(OscHttp, ServerThatIsNotACameraIsRecognized) {
  constexpr FaultKind kWrong = FaultKind::kWrongDevice;
  EXPECT_THAT(fault_of(kWrong, says(http("200 OK", "text/html", "<html>\nLog in</html>"))),
              HasSubstr("no JSON object but '<html>\\nLog in</html>'"));
  EXPECT_THAT(fault_of(kWrong, says(http("200 OK", "application/json", "{\"model\": \"The"))),
              HasSubstr("no JSON object"));
  EXPECT_THAT(fault_of(kWrong, says(http("200 OK", "application/json", "[1, 2]"))),
              HasSubstr("no JSON object"));
  EXPECT_THAT(fault_of(FaultKind::kNoContact, says(http("200 OK", "application/json", ""))),
              HasSubstr("answers with nothing"));
  EXPECT_THAT(fault_of(kWrong, says(http("200 OK", "application/json", "{\"uptime\": 7}"))),
              HasSubstr("neither manufacturer nor model"));
  EXPECT_THAT(fault_of(kWrong, says(http("404 Not Found", "text/html", "<h1>?</h1>"))),
              HasSubstr("HTTP 404"));
  EXPECT_THAT(fault_of(FaultKind::kNoContact, says(http("500 Oops", "text/html", "<h1>!</h1>"))),
              HasSubstr("HTTP 500"));
}

TEST(OscHttp, EndlessAnswerIsCutOff) {
  const auto endless = [](int socket, const std::atomic<bool>& ending) {
    send_text(socket, "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n\r\n");
    const std::string block(1 << 16, ' ');
    while (!ending && send(socket, block.data(), block.size(), MSG_NOSIGNAL) > 0) {
    }
  };
  EXPECT_THAT(fault_of(FaultKind::kWrongDevice, endless), HasSubstr("longer than"));
}

TEST(OscHttp, ServerThatBreaksTheProtocolIsNoContact) {
  constexpr FaultKind kNone = FaultKind::kNoContact;
  EXPECT_THAT(fault_of(kNone, says("")), HasSubstr("no complete reply"));
  EXPECT_THAT(fault_of(kNone, says("\x01\x02\x03 garbage\r\n\r\n")),
              HasSubstr("no complete reply"));
  EXPECT_THAT(fault_of(kNone, says("HTTP/1.1 200 OK\r\nContent-")), HasSubstr("no complete reply"));
  EXPECT_THAT(
      fault_of(kNone, says("HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\n{\"model\": \"T\"}")),
      HasSubstr("no complete reply"));
}

TEST(OscHttp, SilenceEndsWithTheTimeout) {
  const auto silence = [](int, const std::atomic<bool>& ending) {
    const auto end = steady_clock::now() + std::chrono::seconds(30);
    while (!ending && steady_clock::now() < end) std::this_thread::sleep_for(milliseconds(5));
  };
  EXPECT_THAT(fault_of(FaultKind::kNoContact, silence), HasSubstr("within 200 ms"));
}

// Each byte arrives within the timeout of a read; the whole reply never ends.
TEST(OscHttp, SlowReplyEndsWithTheTotalTimeout) {
  const auto drip = [](int socket, const std::atomic<bool>& ending) {
    send_text(socket, "HTTP/1.1 200 OK\r\nX: ");
    while (!ending && send(socket, "y", 1, MSG_NOSIGNAL) == 1) {
      std::this_thread::sleep_for(milliseconds(20));
    }
  };
  EXPECT_THAT(fault_of(FaultKind::kNoContact, drip), HasSubstr("within 400 ms"));
}

TEST(OscHttp, PictureThatBreaksOffIsNotReturned) {
  RawServer server(says("HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\nonly this"));
  ManualClock clock;
  OscClient client(config_of(server), clock);
  EXPECT_THROW(client.fetch(server.url() + "/files/R0010001.JPG"), DeviceFault);
}

TEST(OscHttp, FileThatIsNotThereIsABadPicture) {
  RawServer server(says(http("404 Not Found", "text/plain", "no")));
  ManualClock clock;
  OscClient client(config_of(server), clock);
  try {
    client.fetch(server.url() + "/files/R0010001.JPG");
    FAIL();
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kBadPicture);
    EXPECT_THAT(fault.what(), HasSubstr("/files/R0010001.JPG: HTTP 404"));
  }
}

// The address in the reply may differ from the configured one.
TEST(OscHttp, FilesAreFetchedFromTheConfiguredAddress) {
  RawServer server(says(http("200 OK", "image/jpeg", "bytes")));
  ManualClock clock;
  OscClient client(config_of(server), clock);
  EXPECT_EQ(client.fetch("http://192.0.2.1/files/R0010001.JPG"), "bytes");
  EXPECT_EQ(client.fetch("files/R0010001.JPG"), "bytes");
}

// The interrupt flag is never cleared, so this runs in a separate process.
TEST(OscHttpDeathTest, InterruptEndsADownload) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto interrupted_download = [] {
    install_interrupt_handlers();
    RawServer server([](int socket, const std::atomic<bool>& ending) {
      send_text(socket, "HTTP/1.1 200 OK\r\nContent-Length: 100000000\r\n\r\n");
      std::raise(SIGTERM);
      while (!ending && send(socket, "y", 1, MSG_NOSIGNAL) == 1) {
        std::this_thread::sleep_for(milliseconds(5));
      }
    });
    ManualClock clock;
    OscConfig config = config_of(server);
    config.picture_timeout_ms = 60000.0;
    OscClient client(config, clock);
    try {
      client.fetch("/files/R0010001.JPG");
    } catch (const Interrupted&) {
      std::_Exit(42);
    }
    std::_Exit(1);
  };
  EXPECT_EXIT(interrupted_download(), testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace raywalk::capture
