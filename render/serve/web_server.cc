#include "render/serve/web_server.h"

#include <fmt/format.h>
#include <microhttpd.h>
#include <netdb.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace raywalk::render {
namespace {

// They keep a page from being misused by another one: its content is what it says, loads nothing
// from elsewhere and tells nobody its address.
constexpr std::pair<const char*, const char*> kSecurityFields[] = {
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
     "connect-src 'self'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; "
     "form-action 'none'"}};

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

MHD_Result add_value(void* into, MHD_ValueKind kind, const char* key, std::size_t key_size,
                     const char* value, std::size_t value_size) {
  auto* request = static_cast<Request*>(into);
  const std::string name(key, key_size);
  const std::string text = value == nullptr ? "" : std::string(value, value_size);
  if (kind == MHD_GET_ARGUMENT_KIND) {
    request->query.emplace(name, text);
  } else {
    (kind == MHD_COOKIE_KIND ? request->cookies : request->fields)[lower_case(name)] = text;
  }
  return MHD_YES;
}

MHD_Result send(MHD_Connection* connection, Reply reply) {
  auto* body = new std::string(std::move(reply.body));
  MHD_Response* response = MHD_create_response_from_buffer_with_free_callback_cls(
      body->size(), body->data(), [](void* held) { delete static_cast<std::string*>(held); }, body);
  if (!reply.type.empty()) MHD_add_response_header(response, "Content-Type", reply.type.c_str());
  for (const auto& [name, value] : reply.fields) {
    MHD_add_response_header(response, name.c_str(), value.c_str());
  }
  for (const auto& [name, value] : kSecurityFields) MHD_add_response_header(response, name, value);
  const MHD_Result queued =
      MHD_queue_response(connection, static_cast<unsigned>(reply.status), response);
  MHD_destroy_response(response);
  return queued;
}

Reply reply_to(const WebServer::Handler& handler, const Request& request) {
  try {
    return handler(request);
  } catch (const HttpFault& fault) {
    return refusal(fault);
  } catch (const Interrupted&) {
    return refusal(HttpFault(503, "the server is stopping"));
  } catch (const std::exception&) {
    return refusal(HttpFault(500, "the server failed to answer"));
  }
}

// Called with the head of a request, then with its body, which GET and HEAD have none of, then at
// its end.
MHD_Result on_request(void* handler, MHD_Connection* connection, const char* path,
                      const char* method, const char*, const char*, std::size_t* body_size,
                      void** seen) {
  static char marker = 0;
  if (std::string_view(method) != "GET" && std::string_view(method) != "HEAD") {
    Reply reply = refusal(HttpFault(405, "only GET and HEAD are served"));
    reply.fields.emplace_back("Allow", "GET, HEAD");
    return send(connection, std::move(reply));
  }
  if (*seen == nullptr) {
    *seen = &marker;
    return MHD_YES;
  }
  if (*body_size != 0) return MHD_NO;
  Request request{.path = path};
  for (const MHD_ValueKind kind : {MHD_HEADER_KIND, MHD_COOKIE_KIND, MHD_GET_ARGUMENT_KIND}) {
    MHD_get_connection_values_n(connection, kind, &add_value, &request);
  }
  // The time that the handler takes does not count as the client's.
  const unsigned silence_s =
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_TIMEOUT)
          ->connection_timeout;
  MHD_set_connection_option(connection, MHD_CONNECTION_OPTION_TIMEOUT, 0U);
  Reply reply = reply_to(*static_cast<const WebServer::Handler*>(handler), request);
  MHD_set_connection_option(connection, MHD_CONNECTION_OPTION_TIMEOUT, silence_s);
  return send(connection, std::move(reply));
}

MHD_Daemon* start(const std::string& host, int port, unsigned silence_s,
                  WebServer::Handler* handler) {
  addrinfo* found = nullptr;
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return nullptr;
  const unsigned v6 = found->ai_family == AF_INET6 ? unsigned{MHD_USE_IPv6} : 0U;
  MHD_Daemon* daemon = MHD_start_daemon(
      MHD_USE_AUTO | MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | v6, 0,
      nullptr, nullptr, &on_request, handler, MHD_OPTION_SOCK_ADDR, found->ai_addr,
      MHD_OPTION_CONNECTION_LIMIT, kMostConnections, MHD_OPTION_PER_IP_CONNECTION_LIMIT,
      kMostPerAddress, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionMemory_bytes,
      MHD_OPTION_CONNECTION_TIMEOUT, silence_s, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_END);
  freeaddrinfo(found);
  return daemon;
}

}  // namespace

Reply refusal(const HttpFault& fault) {
  const nlohmann::json body{{"error", fault.what()}};
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // what is no UTF-8
  return {.status = fault.status(),
          .type = "application/json",
          .body = body.dump(-1, ' ', false, kReplace) + "\n"};
}

WebServer::WebServer(const std::string& host, int port, Handler handler, unsigned silence_s)
    : handler_(std::move(handler)),
      daemon_(start(host, port, silence_s, &handler_), &MHD_stop_daemon) {
  if (daemon_ != nullptr) return;
  throw Error(
      fmt::format("cannot listen on {}:{}; the port is in use by another program (choose another "
                  "one), or the address is not one of this machine",
                  host, port));
}

WebServer::~WebServer() = default;

int WebServer::port() const {
  return MHD_get_daemon_info(daemon_.get(), MHD_DAEMON_INFO_BIND_PORT)->port;
}

}  // namespace raywalk::render
