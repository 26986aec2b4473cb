#include "core/http/client_connection.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/interrupt.h"

namespace raywalk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kStep{50};  // how soon a stop is noticed
constexpr std::chrono::milliseconds kLinger{500};
constexpr int kMostRequests = 10'000;  // on one connection
constexpr std::string_view kHeadEnd = "\r\n\r\n";

// A socket with deadlines. Timeouts of the socket itself would begin anew with every byte.
class TimedSocket {
 public:
  TimedSocket(int socket, const std::function<bool()>& stopping)
      : socket_(socket), stopping_(stopping) {}
  ~TimedSocket() { close(socket_); }
  TimedSocket(const TimedSocket&) = delete;
  TimedSocket& operator=(const TimedSocket&) = delete;

  enum class Outcome { kDone, kClosed, kTimeout };

  // Appends what has arrived, waiting for it.
  Outcome read(Clock::time_point deadline, std::string* text) {
    std::array<char, 4096> bytes{};
    for (;;) {
      const Outcome waited = wait_for(POLLIN, deadline);
      if (waited != Outcome::kDone) return waited;
      const ssize_t count = recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (count > 0) {
        text->append(bytes.data(), static_cast<std::size_t>(count));
        return Outcome::kDone;
      }
      if (count == 0 || !may_try_again()) return Outcome::kClosed;
    }
  }

  bool write(Clock::time_point deadline, std::string_view text) {
    while (!text.empty()) {
      if (wait_for(POLLOUT, deadline) != Outcome::kDone) return false;
      const ssize_t count = send(socket_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (count < 0 && !may_try_again()) return false;
      text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    }
    return true;
  }

  // Lets the client read the last reply: closing a socket with unread bytes would discard it.
  void linger() {
    shutdown(socket_, SHUT_WR);
    std::string ignored;
    const Clock::time_point deadline = Clock::now() + kLinger;
    while (read(deadline, &ignored) == Outcome::kDone) ignored.clear();
  }

 private:
  static bool may_try_again() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

  Outcome wait_for(short events, Clock::time_point deadline) {
    while (!stopping_()) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
      if (left.count() <= 0) return Outcome::kTimeout;
      pollfd descriptor = {socket_, events, 0};
      const int ready = poll(&descriptor, 1, static_cast<int>(std::min(left, kStep).count()) + 1);
      if (ready > 0) return Outcome::kDone;
      if (ready < 0 && errno != EINTR) return Outcome::kClosed;
    }
    return Outcome::kClosed;
  }

  int socket_;
  const std::function<bool()>& stopping_;
};

// Refuses a head whose line or whole is too long before its end has arrived.
void require_short(std::string_view arrived) {
  if (arrived.size() > kMostRequestLine && arrived.find("\r\n") > kMostRequestLine) {
    throw HttpFault(414, "the address is too long");
  }
  if (arrived.size() > kMostRequestHead)
    throw HttpFault(431, "the head of the request is too long");
}

class Connection {
 public:
  Connection(int socket, const ConnectionTimes& times, const RequestHandler& handler,
             const std::function<bool()>& stopping)
      : socket_(socket, stopping), times_(times), handler_(handler) {}

  void serve() {
    for (int left = kMostRequests; left > 0; --left) {
      ReplyForm form{.last = left == 1};
      const std::optional<Reply> reply = answer(&form);
      if (!reply) return;
      if (!write(*reply, form)) return;
      if (form.last) return socket_.linger();
    }
  }

 private:
  // The reply to the next request; none at the end of the connection.
  std::optional<Reply> answer(ReplyForm* form) {
    try {
      const std::optional<std::string> text = read_head();
      if (!text) return std::nullopt;
      const RequestHead head = parse_request_head(*text);
      form->with_body = head.method != "HEAD";
      form->last = form->last || !keeps_alive(head);
      return handled(head);
    } catch (const HttpFault& fault) {
      // Where the next request begins is unknown.
      form->last = true;
      return refusal(fault);
    }
  }

  Reply handled(const RequestHead& head) {
    try {
      return handler_(head);
    } catch (const HttpFault& fault) {
      return refusal(fault);
    } catch (const Interrupted&) {
      return refusal(HttpFault(503, "the server is stopping"));
    } catch (const std::exception&) {
      return refusal(HttpFault(500, "the server failed to answer"));
    }
  }

  // Up to and with its empty line.
  std::optional<std::string> read_head() {
    const Clock::time_point idle_end = Clock::now() + times_.idle;
    while (arrived_.empty()) {
      if (socket_.read(idle_end, &arrived_) != TimedSocket::Outcome::kDone) return std::nullopt;
      skip_empty_lines();
    }
    const Clock::time_point deadline = Clock::now() + times_.head;
    std::size_t end = arrived_.find(kHeadEnd);
    while (end == std::string::npos) {
      require_short(arrived_);
      const TimedSocket::Outcome outcome = socket_.read(deadline, &arrived_);
      if (outcome == TimedSocket::Outcome::kClosed) return std::nullopt;
      if (outcome == TimedSocket::Outcome::kTimeout) {
        throw HttpFault(408, "the request did not arrive in time");
      }
      end = arrived_.find(kHeadEnd);
    }
    std::string head = arrived_.substr(0, end + kHeadEnd.size());
    arrived_.erase(0, head.size());
    skip_empty_lines();
    return head;
  }

  // Empty lines before a request are passed over (RFC 9112, 2.2).
  void skip_empty_lines() {
    while (arrived_.starts_with("\r\n")) arrived_.erase(0, 2);
  }

  bool write(const Reply& reply, const ReplyForm& form) {
    const Clock::time_point deadline = Clock::now() + times_.reply;
    return socket_.write(deadline, head_text(reply, form)) &&
           (!form.with_body || socket_.write(deadline, reply.body));
  }

  TimedSocket socket_;
  const ConnectionTimes& times_;
  const RequestHandler& handler_;
  std::string arrived_;  // and not yet answered
};

}  // namespace

void serve_connection(int socket, const ConnectionTimes& times, const RequestHandler& handler,
                      const std::function<bool()>& stopping) {
  Connection(socket, times, handler, stopping).serve();
}

}  // namespace raywalk
