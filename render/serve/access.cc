#include "render/serve/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <strings.h>

#include <cctype>
#include <random>
#include <utility>

namespace raywalk::render {
namespace {

constexpr const char* kCookie = "raywalk_token";

std::string random_token() {
  std::random_device bits;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", bits(), bits(), bits(), bits());
}

// The name in a Host field: without its port, an IPv6 address without brackets.
std::string host_of(const Request& request) {
  const std::string field = value_of(request.fields, "host");
  return field.starts_with('[') ? field.substr(1, field.find(']') - 1)
                                : field.substr(0, field.find(':'));
}

// In a time that tells nothing about where they differ.
bool are_equal(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

// The address of the page with the parameters of the request but for the token.
std::string page_of(const Request& request) {
  std::string page = "/";
  const auto append = [&page](char separator, const std::string& text) {
    page += separator;
    for (const char c : text) {
      const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
      page += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  };
  for (const auto& [name, value] : request.query) {
    if (name == kTokenParameter) continue;
    append(page == "/" ? '?' : '&', name);
    append('=', value);
  }
  return page;
}

}  // namespace

bool is_loopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return strcasecmp(host.c_str(), "localhost") == 0 || host == "::1";
}

Access::Access(std::string host) : host_(std::move(host)) {
  if (!is_loopback(host_)) token_ = random_token();
}

std::optional<Reply> Access::check(const Request& request) const {
  if (token_.empty()) {
    const std::string host = host_of(request);
    if (is_loopback(host) || strcasecmp(host.c_str(), host_.c_str()) == 0) return std::nullopt;
    throw HttpFault(421, "this server answers to localhost alone");
  }
  const auto given = request.query.find(kTokenParameter);
  if (given != request.query.end() && are_equal(given->second, token_)) {
    const std::string cookie =
        fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", kCookie, token_);
    return Reply{
        .status = 303,
        .fields = {
            {"Location", page_of(request)}, {"Set-Cookie", cookie}, {"Cache-Control", "no-store"}}};
  }
  if (are_equal(value_of(request.cookies, kCookie), token_)) return std::nullopt;
  throw HttpFault(401, "open the address that raywalk-render serve has printed, with its token");
}

}  // namespace raywalk::render
