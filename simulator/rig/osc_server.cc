#include "simulator/rig/osc_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/error.h"
#include "core/base/escaped.h"

namespace raywalk::simulator {
namespace {

constexpr const char* kHost = "127.0.0.1";
constexpr const char* kJson = "application/json";
constexpr std::chrono::milliseconds kStep{2};     // until it is asked again whether a fault lasts
constexpr std::chrono::seconds kSilentReply{30};  // longer than any client's timeout
constexpr std::size_t kMostClients = 64;
constexpr const char* kWebPage =
    "<!DOCTYPE html><html><head><title>Camera</title></head><body>Please log in.</body></html>";

// httplib closes the connection when a content provider fails. The client receives a header with a
// content length and then the end of the stream.
void send_truncated(httplib::Response* response) {
  response->body.clear();
  response->set_content_provider(
      1, kJson, [](std::size_t, std::size_t, httplib::DataSink&) { return false; });
}

}  // namespace

OscServer::OscServer(SimulatedCamera* camera, Faults* faults, int port,
                     const std::map<std::string, Handler>& more)
    : camera_(camera), faults_(faults), server_(std::make_unique<httplib::Server>()) {
  // httplib's default, SO_REUSEPORT, would let two servers share a port.
  server_->set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  server_->set_tcp_nodelay(true);
  // httplib deletes it.
  server_->new_task_queue = [] { return new httplib::ThreadPool(kMostClients); };
  // A client may keep its connection open for a whole session.
  server_->set_keep_alive_max_count(1'000'000);
  server_->set_keep_alive_timeout(1);
  add_camera();
  for (const auto& [path, handler] : more) {
    const auto handle = [handler = handler](const httplib::Request& request,
                                            httplib::Response& response) {
      try {
        response.set_content(handler(request.body), kJson);
      } catch (const Error& error) {
        response.status = 400;
        const nlohmann::json refusal{{"error", {{"message", escaped(error.what())}}}};
        response.set_content(refusal.dump(), kJson);
      }
    };
    server_->Get(path, handle);
    server_->Post(path, handle);
  }
  port_ = port == 0 ? server_->bind_to_any_port(kHost) : port;
  if (port_ < 1 || (port != 0 && !server_->bind_to_port(kHost, port))) {
    throw Error(
        fmt::format("cannot listen on {}:{}; is the port in use by another program?", kHost, port));
  }
  thread_ = std::thread([this] { server_->listen_after_bind(); });
}

// httplib only stops a server that listens.
OscServer::~OscServer() {
  ending_ = true;
  while (!server_->is_running()) std::this_thread::sleep_for(kStep);
  server_->stop();
  thread_.join();
}

std::string OscServer::url() const { return fmt::format("http://{}:{}", kHost, port_); }

void OscServer::add_camera() {
  server_->Get("/osc/info", [this](const auto&, auto& response) {
    answer([] { return SimulatedCamera::info(); }, &response);
  });
  server_->Post("/osc/state", [this](const auto&, auto& response) {
    answer([this] { return camera_->state(); }, &response);
  });
  server_->Post("/osc/commands/execute", [this](const auto& request, auto& response) {
    answer([&] { return camera_->execute(request.body); }, &response);
  });
  server_->Post("/osc/commands/status", [this](const auto& request, auto& response) {
    answer([&] { return camera_->status(request.body, url()); }, &response);
  });
  server_->Get(R"(/files/([A-Za-z0-9_.]+))", [this](const auto& request, auto& response) {
    send_file(request.matches[1], &response);
  });
}

void OscServer::answer(const std::function<OscReply()>& reply, httplib::Response* response) {
  if (faults_->occurs(RigFault::kDown)) return send_truncated(response);
  const OscReply made = reply();
  if (stays_silent()) return send_truncated(response);
  response->status = made.http_status;
  response->set_content(made.json.dump(), kJson);
}

void OscServer::send_file(const std::string& name, httplib::Response* response) {
  if (faults_->occurs(RigFault::kDown) || stays_silent()) return send_truncated(response);
  if (faults_->occurs(RigFault::kWebPage)) return response->set_content(kWebPage, "text/html");
  try {
    response->set_content(camera_->file(name), "image/jpeg");
  } catch (const Error&) {
    response->status = 404;
  }
}

// Keeps the client waiting, for the duration of the fault if it has one.
bool OscServer::stays_silent() {
  const bool lasts = faults_->lasting(RigFault::kSilent).has_value();
  if (!faults_->occurs(RigFault::kSilent)) return false;
  const auto end = std::chrono::steady_clock::now() + kSilentReply;
  const auto waits = [&] {
    return lasts ? faults_->lasting(RigFault::kSilent).has_value()
                 : std::chrono::steady_clock::now() < end;
  };
  while (!ending_ && waits()) std::this_thread::sleep_for(kStep);
  return true;
}

}  // namespace raywalk::simulator
