#include "core/http/reply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/base/escaped.h"

namespace raywalk {
namespace {

constexpr int kNotModified = 304;

constexpr std::array<std::pair<int, std::string_view>, 19> kReasons{
    {{200, "OK"},
     {206, "Partial Content"},
     {303, "See Other"},
     {kNotModified, "Not Modified"},
     {400, "Bad Request"},
     {401, "Unauthorized"},
     {404, "Not Found"},
     {405, "Method Not Allowed"},
     {408, "Request Timeout"},
     {413, "Content Too Large"},
     {414, "URI Too Long"},
     {416, "Range Not Satisfiable"},
     {417, "Expectation Failed"},
     {421, "Misdirected Request"},
     {422, "Unprocessable Content"},
     {431, "Request Header Fields Too Large"},
     {500, "Internal Server Error"},
     {503, "Service Unavailable"},
     {505, "HTTP Version Not Supported"}}};

constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kSecurityFields{
    {{"X-Content-Type-Options", "nosniff"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Content-Security-Policy",
      "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
      "connect-src 'self'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; "
      "form-action 'none'"}}};

std::string_view reason_of(int status) {
  const auto* const found = std::find_if(
      kReasons.begin(), kReasons.end(), [&](const auto& reason) { return reason.first == status; });
  return found == kReasons.end() ? "" : found->second;
}

void add(std::string_view name, std::string_view value, std::string* text) {
  text->append(name).append(": ");
  for (const char c : value) *text += c >= ' ' && c < '\x7f' ? c : '?';
  text->append("\r\n");
}

}  // namespace

Reply refusal(const HttpFault& fault) {
  const nlohmann::json body{{"error", escaped(fault.what())}};
  return {.status = fault.status(), .type = "application/json", .body = body.dump() + "\n"};
}

std::string head_text(const Reply& reply, const ReplyForm& form) {
  std::string text = fmt::format("HTTP/1.1 {} {}\r\n", reply.status, reason_of(reply.status));
  if (!reply.type.empty()) add("Content-Type", reply.type, &text);
  // A length there would have to be that of the file.
  if (reply.status != kNotModified) add("Content-Length", std::to_string(reply.body.size()), &text);
  for (const auto& [name, value] : reply.fields) add(name, value, &text);
  for (const auto& [name, value] : kSecurityFields) add(name, value, &text);
  if (form.last) add("Connection", "close", &text);
  return text + "\r\n";
}

}  // namespace raywalk
