// What a server answers, and its text on the wire.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/http/http_fault.h"

namespace raywalk {

struct Reply {
  int status = 200;
  std::string type{};  // media type of the body; empty without a body
  std::string body{};
  std::vector<std::pair<std::string, std::string>> fields{};  // further ones, such as ETag
};

// {"error": "SENTENCE"}
Reply refusal(const HttpFault& fault);

struct ReplyForm {
  bool with_body = true;  // false: for HEAD, with the fields of the body
  bool last = false;      // the connection closes behind it
};

// The status line and the fields, with those that keep a page from being misused by another one:
// its content is what it says (nosniff), loads nothing from elsewhere (Content-Security-Policy) and
// tells nobody its address. In values, what is not printable ASCII becomes '?'.
std::string head_text(const Reply& reply, const ReplyForm& form);

}  // namespace raywalk
