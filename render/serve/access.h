// Who may use the server: on loopback every program of this machine, elsewhere who has the token.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/http/reply.h"
#include "core/http/request_head.h"
#include "core/http/request_target.h"

namespace raywalk::render {

inline constexpr const char* kTokenParameter = "token";
inline constexpr const char* kTokenCookie = "raywalk_token";

// Whether an address or name to listen on is one of this machine alone: localhost, 127.0.0.0/8,
// ::1.
bool is_loopback(const std::string& host);

// 128 random bits of the kernel as 32 hexadecimal digits. Throws Error where there are none.
std::string random_token();

// Whether two texts are equal, in a time that tells nothing about where they differ.
bool equal_in_constant_time(std::string_view a, std::string_view b);

class Access {
 public:
  // `host` is what the server listens on. A token is made unless it is loopback.
  explicit Access(std::string host);

  // None: everybody on loopback.
  const std::optional<std::string>& token() const { return token_; }

  // None where the request may be answered. With the right token in the address: a redirection to
  // the address without it that sets the cookie. Throws HttpFault: 421 on loopback where Host is
  // neither loopback nor the host given, so that a page from elsewhere cannot have its own name
  // point here (DNS rebinding); else 401 without the token.
  std::optional<Reply> check(const RequestHead& head, const RequestTarget& target) const;

 private:
  void require_own_host(const RequestHead& head) const;

  std::string host_;
  std::optional<std::string> token_;
};

}  // namespace raywalk::render
