#include "render/serve/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cstdint>
#include <utility>

#include "core/base/error.h"
#include "core/http/field_text.h"

namespace raywalk::render {
namespace {

// The name of a Host field, without its port and in lower case; an IPv6 address without brackets.
std::string name_of_host(std::string_view field) {
  if (field.starts_with('[')) {
    const std::size_t end = field.find(']');
    const std::string_view port = field.substr(std::min(end, field.size() - 1) + 1);
    const bool is_host = end != std::string_view::npos && (port.empty() || port.starts_with(':'));
    return is_host ? lower_case(field.substr(1, end - 1)) : "";
  }
  return lower_case(field.substr(0, field.find(':')));
}

}  // namespace

bool is_loopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return lower_case(host) == "localhost" || host == "::1";
}

std::string random_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw Error("cannot make a token: the system has no random numbers");
  }
  std::string token;
  for (const std::uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

Access::Access(std::string host) : host_(std::move(host)) {
  if (!is_loopback(host_)) token_ = random_token();
}

std::optional<Reply> Access::check(const RequestHead& head, const RequestTarget& target) const {
  if (!token_) {
    require_own_host(head);
    return std::nullopt;
  }
  const std::optional<std::string> given = parameter_of(target, kTokenParameter);
  if (given && equal_in_constant_time(*given, *token_)) {
    return Reply{.status = 303,
                 .fields = {{"Location", target_without(target, kTokenParameter)},
                            {"Set-Cookie", fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/",
                                                       kTokenCookie, *token_)},
                            {"Cache-Control", "no-store"}}};
  }
  if (equal_in_constant_time(cookie_of(head, kTokenCookie), *token_)) return std::nullopt;
  throw HttpFault(401, "open the address that raywalk-render serve has printed, with its token");
}

void Access::require_own_host(const RequestHead& head) const {
  const std::string* field = field_of(head, "host");
  const std::string name = field == nullptr ? "" : name_of_host(*field);
  if (is_loopback(name) || (!name.empty() && name == lower_case(host_))) return;
  throw HttpFault(421, "this server answers to localhost alone");
}

}  // namespace raywalk::render
