#include "simulator/rig/osc_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "simulator/rig/osc_api.h"

namespace raywalk::capture {
namespace {

constexpr const char* kHost = "127.0.0.1";
constexpr const char* kJson = "application/json";
constexpr std::chrono::milliseconds kStep{2};     // polling interval of the faults
constexpr std::chrono::seconds kSilentReply{30};  // longer than any client's timeout
constexpr std::size_t kMostClients = 64;
constexpr const char* kWebPage =
    "<!DOCTYPE html><html><head><title>Camera</title></head><body>Please log in.</body></html>";

// httplib closes the connection when a content provider fails. The client receives a header with a
// content length and then the end of the stream.
void send_truncated(httplib::Response& response) {
  response.body.clear();
  response.set_content_provider(1, kJson,
                                [](std::size_t, std::size_t, httplib::DataSink&) { return false; });
}

}  // namespace

class OscServer::Impl {
 public:
  Impl(SimulatedCamera& camera, int port) : camera_(camera), api_(camera) {
    // httplib's default, SO_REUSEPORT, would let two servers share a port.
    server_.set_socket_options([](int socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server_.set_tcp_nodelay(true);
    // httplib deletes it.
    server_.new_task_queue = [] { return new httplib::ThreadPool(kMostClients); };
    // A client may keep its connection open for a whole session.
    server_.set_keep_alive_max_count(1'000'000);
    server_.set_keep_alive_timeout(1);
    port_ = port == 0 ? server_.bind_to_any_port(kHost) : port;
    if (port_ < 1 || (port != 0 && !server_.bind_to_port(kHost, port))) {
      throw Error(fmt::format("cannot listen on {}:{}; is the port in use by another program?",
                              kHost, port));
    }
    bound_ = true;
    add_camera();
  }

  ~Impl() { stop(); }

  void add(bool is_post, const std::string& path, Handler handler) {
    const auto handle = [this, handler = std::move(handler)](const httplib::Request& request,
                                                             httplib::Response& response) {
      if (disconnects(response)) return;
      try {
        response.set_content(handler(request.body), kJson);
      } catch (const Error& error) {
        response.status = 400;
        const nlohmann::json refusal{{"error", {{"message", escaped(error.what())}}}};
        response.set_content(refusal.dump(), kJson);
      }
    };
    if (is_post) {
      server_.Post(path, handle);
    } else {
      server_.Get(path, handle);
    }
  }

  void start() {
    if (thread_.joinable()) return;
    stopping_ = false;
    ended_ = false;
    if (!bound_ && !server_.bind_to_port(kHost, port_)) {
      throw Error(
          fmt::format("cannot listen on {} again; the port is in use by another program", url()));
    }
    thread_ = std::thread([this] { serve(); });
    bound_ = true;
  }

  void stop() {
    // httplib closes its socket only if it has been listening.
    if (bound_ && !thread_.joinable()) start();
    if (!thread_.joinable()) return;
    stopping_ = true;
    woken_.notify_all();
    std::unique_lock lock(mutex_);
    while (!ended_) {
      stop_listening();
      woken_.wait_for(lock, kStep);
    }
    lock.unlock();
    thread_.join();
    bound_ = false;
  }

  int port() const { return port_; }
  std::string url() const { return fmt::format("http://{}:{}", kHost, port_); }

 private:
  void add_camera() {
    server_.Get("/osc/info", [this](const auto&, auto& response) {
      answer(response, [this] { return api_.info(); });
    });
    server_.Post("/osc/state", [this](const auto&, auto& response) {
      answer(response, [this] { return api_.state(url()); });
    });
    server_.Post("/osc/commands/execute", [this](const auto& request, auto& response) {
      answer(response, [&] { return api_.execute(request.body, url()); });
    });
    server_.Post("/osc/commands/status", [this](const auto& request, auto& response) {
      answer(response, [&] { return api_.status(request.body, url()); });
    });
    server_.Get(R"(/files/([A-Za-z0-9_.]+))", [this](const auto& request, auto& response) {
      send_file(request.matches[1], response);
    });
  }

  template <typename Reply>
  void answer(httplib::Response& response, const Reply& reply) {
    if (disconnects(response)) return;
    const OscReply made = reply();
    if (stays_silent(response)) return;
    response.status = made.http_status;
    response.set_content(made.json, kJson);
  }

  void send_file(const std::string& name, httplib::Response& response) {
    if (disconnects(response) || stays_silent(response)) return;
    if (camera_.faults().occurs(CameraFault::kWebPage)) {
      response.set_content(kWebPage, "text/html");
      return;
    }
    try {
      response.set_content(camera_.card().read(name), "image/jpeg");
    } catch (const Error&) {
      response.status = 404;
    }
  }

  bool disconnects(httplib::Response& response) {
    const bool lasting = camera_.faults().lasts(CameraFault::kDown);
    if (!camera_.faults().occurs(CameraFault::kDown)) return false;
    if (lasting) stop_listening();
    send_truncated(response);
    return true;
  }

  // Keeps the client waiting for the duration of the fault, then closes without a reply.
  bool stays_silent(httplib::Response& response) {
    const bool lasting = camera_.faults().lasts(CameraFault::kSilent);
    if (!camera_.faults().occurs(CameraFault::kSilent)) return false;
    const auto end = std::chrono::steady_clock::now() + kSilentReply;
    wait_until([&] {
      return lasting ? !camera_.faults().lasts(CameraFault::kSilent)
                     : std::chrono::steady_clock::now() >= end;
    });
    send_truncated(response);
    return true;
  }

  // Waits until the condition holds or the server is stopped.
  template <typename Condition>
  void wait_until(const Condition& condition) {
    std::unique_lock lock(mutex_);
    while (!stopping_ && !condition()) woken_.wait_for(lock, kStep);
  }

  // Listens, and after the fault kDown listens again on the same port.
  void serve() {
    for (bool bound = true; bound; bound = rebind()) {
      closing_ = false;
      server_.listen_after_bind();
    }
    ended_ = true;
  }

  bool rebind() {
    wait_until([this] { return !camera_.faults().lasts(CameraFault::kDown); });
    bool bound = false;
    wait_until([&] { return bound = server_.bind_to_port(kHost, port_); });
    return bound;
  }

  // httplib::Server::stop() must be called exactly once per listen(), and only while it listens.
  void stop_listening() {
    if (server_.is_running() && !closing_.exchange(true)) server_.stop();
  }

  SimulatedCamera& camera_;
  OscApi api_;
  httplib::Server server_;
  int port_ = 0;
  bool bound_ = false;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> closing_ = false;  // since it last began to listen
  std::atomic<bool> ended_ = false;    // the thread has
  std::mutex mutex_;
  std::condition_variable woken_;
  std::thread thread_;
};

OscServer::OscServer(SimulatedCamera& camera, int port)
    : impl_(std::make_unique<Impl>(camera, port)) {}
OscServer::~OscServer() = default;

void OscServer::on_get(const std::string& path, Handler handler) {
  impl_->add(false, path, std::move(handler));
}
void OscServer::on_post(const std::string& path, Handler handler) {
  impl_->add(true, path, std::move(handler));
}
void OscServer::start() { impl_->start(); }
void OscServer::stop() { impl_->stop(); }
int OscServer::port() const { return impl_->port(); }
std::string OscServer::url() const { return impl_->url(); }

}  // namespace raywalk::capture
