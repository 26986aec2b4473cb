#include "capture/camera/osc_http.h"

#include <fmt/format.h>
#include <httplib.h>

#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <stop_token>
#include <thread>

#include "capture/base/device_fault.h"
#include "capture/base/http_url.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

// Headers required by the Open Spherical Camera API (protocol pages of Google and of Insta360).
const httplib::Headers kHeaders = {{"Accept", "*/*"}, {"X-XSRF-Protected", "1"}};
constexpr const char* kJson = "application/json;charset=utf-8";

std::string checked_url(const std::string& url) {
  const HttpUrl split = split_url(url);
  const bool has_path = split.path.find_first_not_of('/') != std::string::npos;
  if (is_http_url(url) && !has_path) return split.server;
  throw UsageError("camera.osc.url is " + excerpt(url) +
                   "; it must be an address like http://192.168.1.1");
}

// Ends a request after its total time. httplib's timeouts are per system call, so a server that
// sends single bytes could delay it without end.
class RequestDeadline {
 public:
  RequestDeadline(httplib::Client& client, double timeout_ms)
      : thread_([this, &client, timeout_ms](const std::stop_token& token) {
          std::unique_lock lock(mutex_);
          const auto never = [] { return false; };
          ended_.wait_for(lock, token, duration_from_ms(timeout_ms), never);
          if (token.stop_requested()) return;
          passed_ = true;
          client.stop();
        }) {}

  bool end() {
    thread_.request_stop();
    thread_.join();
    return passed_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any ended_;
  bool passed_ = false;
  std::jthread thread_;
};

}  // namespace

class OscHttp::Connection {
 public:
  Connection(const std::string& url, double connect_timeout_ms)
      : url_(url), connect_timeout_ms_(connect_timeout_ms), client_(url) {
    const auto timeout = duration_from_ms(connect_timeout_ms);
    client_.set_connection_timeout(timeout);
    client_.set_read_timeout(timeout);
    client_.set_write_timeout(timeout);
    client_.set_keep_alive(true);
    client_.set_tcp_nodelay(true);
  }

  void close() { client_.stop(); }

  HttpReply send(httplib::Request request, double total_timeout_ms, std::size_t max_bytes) {
    HttpReply reply;
    bool too_long = false;
    request.headers.insert(kHeaders.begin(), kHeaders.end());
    request.content_receiver = [&](const char* data, std::size_t length, std::uint64_t,
                                   std::uint64_t) {
      too_long = reply.body.size() + length > max_bytes;
      if (too_long || interrupt_requested()) return false;
      reply.body.append(data, length);
      return true;
    };
    const std::string where = url_ + request.path;
    RequestDeadline deadline(client_, total_timeout_ms);
    httplib::Response response;
    httplib::Error error = httplib::Error::Success;
    const bool answered = client_.send(request, response, error);
    const bool late = deadline.end();
    if (!answered) throw_if_interrupted();
    if (too_long) refuse_too_long(where, max_bytes);
    if (!answered) refuse_no_answer(where, error, late ? total_timeout_ms : connect_timeout_ms_);
    reply.status = response.status;
    reply.content_type = response.get_header_value("Content-Type");
    if (response.has_header("Content-Length") && !response.has_header("Content-Encoding")) {
      const std::string length = response.get_header_value("Content-Length");
      reply.promised_bytes = std::strtoull(length.c_str(), nullptr, 10);
    }
    return reply;
  }

 private:
  [[noreturn]] static void refuse_too_long(const std::string& where, std::size_t max_bytes) {
    throw DeviceFault(FaultKind::kWrongDevice,
                      fmt::format("{}: the answer is longer than {} bytes; check camera.osc.url",
                                  where, max_bytes));
  }

  [[noreturn]] static void refuse_no_answer(const std::string& where, httplib::Error error,
                                            double timeout_ms) {
    using httplib::Error;
    const bool unconnected = error == Error::Connection || error == Error::ConnectionTimeout;
    throw DeviceFault(
        FaultKind::kNoContact,
        unconnected
            ? fmt::format("{}: no connection to the camera; switch it on, let this computer join "
                          "its network, and check camera.osc.url",
                          where)
            : fmt::format("{}: no complete reply from the camera within {:g} ms; check that it is "
                          "near and switched on",
                          where, timeout_ms));
  }

  std::string url_;
  double connect_timeout_ms_;
  httplib::Client client_;
};

OscHttp::OscHttp(const std::string& url, double connect_timeout_ms)
    : url_(checked_url(url)),
      connect_timeout_ms_(connect_timeout_ms),
      connection_(std::make_unique<Connection>(url_, connect_timeout_ms_)) {}

OscHttp::~OscHttp() = default;

HttpReply OscHttp::get(const std::string& path, double total_timeout_ms, std::size_t max_bytes) {
  httplib::Request request;
  request.method = "GET";
  request.path = path;
  return connection_->send(std::move(request), total_timeout_ms, max_bytes);
}

HttpReply OscHttp::post_json(const std::string& path, const std::string& json,
                             double total_timeout_ms, std::size_t max_bytes) {
  httplib::Request request;
  request.method = "POST";
  request.path = path;
  request.body = json;
  request.headers.emplace("Content-Type", kJson);
  return connection_->send(std::move(request), total_timeout_ms, max_bytes);
}

void OscHttp::use_fresh_connection() { connection_->close(); }

}  // namespace raywalk::capture
