// One client's connection: reads its requests, within limits of size and time, and writes replies.
#pragma once

#include <chrono>
#include <functional>

#include "core/http/reply.h"
#include "core/http/request_head.h"

namespace raywalk {

struct ConnectionTimes {
  std::chrono::milliseconds idle{5'000};     // until a request begins
  std::chrono::milliseconds head{10'000};    // from its first to its last byte
  std::chrono::milliseconds reply{120'000};  // to be read by the client
};

// Answers a request. An HttpFault becomes its refusal(), any other exception status 500, which says
// no more.
using RequestHandler = std::function<Reply(const RequestHead&)>;

// Serves a connected socket until the client closes it, breaks a limit, or `stopping` returns true
// (polled several times a second), and closes it. Requests that were sent without waiting for
// replies are answered in order.
void serve_connection(int socket, const ConnectionTimes& times, const RequestHandler& handler,
                      const std::function<bool()>& stopping);

}  // namespace raywalk
