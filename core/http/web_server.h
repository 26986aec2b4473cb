// A small HTTP/1.1 server for GET and HEAD.
//
// httplib listens and starts the threads; requests are read and replies written here. As packaged
// by Debian 12 (0.11), httplib reads request lines and fields of any length, answers ranges beyond
// the end of a file, waits anew after every byte of a slow client, and refuses units of ranges that
// a server has to ignore.
#pragma once

#include <memory>
#include <string>

#include "core/http/client_connection.h"

namespace raywalk {

inline constexpr std::size_t kMostConnections = 64;

class WebServer {
 public:
  // Binds at once; port 0 chooses a free one. Throws Error where that is not possible. The handler
  // is called on several threads. Up to kMostConnections clients are served at a time; others wait.
  WebServer(const std::string& host, int port, RequestHandler handler,
            const ConnectionTimes& times = {});
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  void start();
  // Closes all connections, waits for the handlers that run, and closes the port. For good.
  void stop();

  int port() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raywalk
