// A small HTTP server for GET and HEAD, on libmicrohttpd.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"

struct MHD_Daemon;

namespace raywalk::render {

// Limits of what clients may take: longer heads are refused, and who sends or reads nothing for a
// while is let go.
inline constexpr unsigned kMostConnections = 1024;  // each has a thread
inline constexpr unsigned kMostPerAddress = 256;
inline constexpr std::size_t kConnectionMemory_bytes = 32768;  // holds the head of a request
inline constexpr unsigned kSilence_s = 10;

// Decoded; of fields and cookies that were sent twice the last one, their names in lower case.
struct Request {
  std::string path{};  // "/view"
  std::multimap<std::string, std::string> query{};
  std::map<std::string, std::string> fields{};
  std::map<std::string, std::string> cookies{};
};

// Of fields or cookies; empty where there is none.
inline std::string value_of(const std::map<std::string, std::string>& values,
                            const std::string& name) {
  const auto found = values.find(name);
  return found == values.end() ? "" : found->second;
}

struct Reply {
  int status = 200;
  std::string type{};  // media type of the body; empty without a body
  std::string body{};
  std::vector<std::pair<std::string, std::string>> fields{};  // further ones, such as ETag
};

// A request that is refused: with a status of 400 to 599 and one sentence.
class HttpFault : public Error {
 public:
  HttpFault(int status, const std::string& sentence) : Error(sentence), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

// {"error": "SENTENCE"}
Reply refusal(const HttpFault& fault);

class WebServer {
 public:
  // Called on many threads. An HttpFault becomes its refusal, any other exception status 500, which
  // says no more.
  using Handler = std::function<Reply(const Request&)>;

  // Serves from now on; port 0 chooses a free one. Throws Error where that is not possible.
  WebServer(const std::string& host, int port, Handler handler, unsigned silence_s = kSilence_s);
  // Closes all connections and the port, and waits for the handlers that run.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  int port() const;

 private:
  Handler handler_;
  std::unique_ptr<MHD_Daemon, void (*)(MHD_Daemon*)> daemon_;
};

}  // namespace raywalk::render
