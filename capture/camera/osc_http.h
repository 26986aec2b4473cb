// HTTP to a camera. Every request has a time limit, whatever the server does.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct HttpReply {
  int status = 0;
  std::string body;
  std::string content_type;
  std::optional<std::uint64_t> promised_bytes{};  // Content-Length of a body that is not compressed
};

// Timeouts use the machine's clock, as sockets do: connect_timeout_ms to connect and for each part
// of a reply, total_timeout_ms for a request as a whole.
class OscHttp {
 public:
  // `url` is "http://host" or "http://host:port". Throws UsageError for anything else.
  OscHttp(const std::string& url, double connect_timeout_ms);
  ~OscHttp();
  OscHttp(const OscHttp&) = delete;
  OscHttp& operator=(const OscHttp&) = delete;

  // Throws DeviceFault: kNoContact without a connection or a complete reply, kWrongDevice if the
  // reply is longer than max_bytes; Interrupted while a body arrives. HTTP errors are returned as
  // replies.
  HttpReply get(const std::string& path, double total_timeout_ms, std::size_t max_bytes);
  HttpReply post_json(const std::string& path, const std::string& json, double total_timeout_ms,
                      std::size_t max_bytes);
  // The next request opens a new connection. A kept connection may have been closed by the server,
  // which is noticed only when a request on it is lost.
  void use_fresh_connection();

  const std::string& url() const { return url_; }

 private:
  class Connection;
  std::string url_;
  double connect_timeout_ms_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace raywalk::capture
