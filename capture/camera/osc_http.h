// HTTP to a camera: every request ends in time, whatever the other side does.
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
  std::string date;                               // the Date header; empty where there is none
  std::optional<std::uint64_t> promised_bytes{};  // Content-Length of a body that is not compressed
};

// The timeouts are those of the machine's own clock, for that is the one sockets know: to connect,
// and for each piece of an answer, connect_timeout_ms; for a request as a whole, as its caller
// says.
class OscHttp {
 public:
  // `url` is "http://host" or "http://host:port". Throws UsageError for anything else.
  OscHttp(const std::string& url, double connect_timeout_ms);
  ~OscHttp();
  OscHttp(const OscHttp&) = delete;
  OscHttp& operator=(const OscHttp&) = delete;

  // Throws DeviceFault: kNoContact if there was no connection or no whole answer, kWrongDevice if
  // the answer is longer than max_bytes; Interrupted while a body arrives. An HTTP error is an
  // answer.
  HttpReply get(const std::string& path, double total_timeout_ms, std::size_t max_bytes);
  HttpReply post_json(const std::string& path, const std::string& json, double total_timeout_ms,
                      std::size_t max_bytes);
  // The next request opens a connection of its own. A connection that is kept may have been closed
  // by the other side, which is noticed only when a request is lost on it.
  void use_fresh_connection();

  const std::string& url() const { return url_; }

 private:
  class Connection;
  std::string url_;
  double connect_timeout_ms_;
  std::unique_ptr<Connection> connection_;
};

}  // namespace raywalk::capture
