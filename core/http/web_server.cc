#include "core/http/web_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/http/connection_threads.h"

namespace raywalk {

class WebServer::Impl final : private httplib::Server {
 public:
  Impl(const std::string& host, int port, RequestHandler handler, const ConnectionTimes& times)
      : handler_(std::move(handler)), times_(times) {
    set_socket_options(reuse_address);
    set_tcp_nodelay(true);  // heads and bodies are sent one after the other
    // httplib deletes it.
    new_task_queue = [] { return new ThreadPerConnection(kMostConnections); };
    port_ = port == 0 ? bind_to_any_port(host) : port;
    if (port_ < 1 || (port != 0 && !bind_to_port(host, port))) {
      throw Error(fmt::format(
          "cannot listen on {}:{}; the port is in use by another program (choose another one), or "
          "the address is not one of this machine",
          host, port));
    }
    // httplib lets five clients wait, so that others would try again a second later.
    ::listen(svr_sock_, static_cast<int>(kMostConnections));
  }
  ~Impl() override { stop_serving(); }

  void start_serving() {
    if (thread_.joinable()) return;
    thread_ = std::thread([this] {
      listen_after_bind();
      ended_ = true;
    });
  }

  void stop_serving() {
    stopping_ = true;
    // httplib closes its socket only where it has been listening.
    if (!stopped_) start_serving();
    stopped_ = true;
    if (!thread_.joinable()) return;
    // It must be told exactly once, and only while it listens.
    for (bool told = false; !ended_; std::this_thread::sleep_for(std::chrono::milliseconds(1))) {
      if (told || !is_running()) continue;
      stop();
      told = true;
    }
    thread_.join();
  }

  int port() const { return port_; }

 private:
  bool process_and_close_socket(socket_t socket) override {
    serve_connection(socket, times_, handler_, [this] { return stopping_.load(); });
    return true;
  }

  RequestHandler handler_;
  ConnectionTimes times_;
  int port_ = 0;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> ended_ = false;  // the thread has
  bool stopped_ = false;
  std::thread thread_;
};

WebServer::WebServer(const std::string& host, int port, RequestHandler handler,
                     const ConnectionTimes& times)
    : impl_(std::make_unique<Impl>(host, port, std::move(handler), times)) {}
WebServer::~WebServer() = default;

void WebServer::start() { impl_->start_serving(); }
void WebServer::stop() { impl_->stop_serving(); }
int WebServer::port() const { return impl_->port(); }

}  // namespace raywalk
