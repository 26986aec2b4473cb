// Who may use the server: on loopback every program of this machine, elsewhere who has the token.
#pragma once

#include <optional>
#include <string>

#include "render/serve/web_server.h"

namespace raywalk::render {

inline constexpr const char* kTokenParameter = "token";

// Whether an address or name to listen on is one of this machine alone: localhost, 127.0.0.0/8,
// ::1.
bool is_loopback(const std::string& host);

class Access {
 public:
  // `host` is what the server listens on. A token of 128 random bits is made unless it is loopback.
  explicit Access(std::string host);

  // Empty: everybody on loopback.
  const std::string& token() const { return token_; }

  // None where the request may be answered. With the right token in the address: a redirection to
  // the page that sets a cookie. Throws HttpFault: 421 on loopback where Host is neither loopback
  // nor the host given, so that a page from elsewhere cannot have its own name point here (DNS
  // rebinding); else 401 without the token.
  std::optional<Reply> check(const Request& request) const;

 private:
  std::string host_;
  std::string token_;
};

}  // namespace raywalk::render
