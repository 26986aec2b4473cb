// What a client sends before the body of a request (RFC 9112): the request line and the fields.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

inline constexpr std::size_t kMostRequestLine = 8192;  // bytes, without its line break
inline constexpr std::size_t kMostRequestHead = 16384;
inline constexpr std::size_t kMostRequestFields = 100;

struct RequestField {
  std::string name{};   // lower case
  std::string value{};  // without the spaces around it
};

struct RequestHead {
  std::string method{};                // "GET"
  std::string target{};                // as sent
  int minor_version = 1;               // of HTTP/1
  std::vector<RequestField> fields{};  // in the order they were sent
};

// The request line and the fields of a request without a body, up to the empty line or the end of
// `text`. Lines end in CRLF. Throws HttpFault: 400 where the text is not a head, with HTTP/1.1 also
// without exactly one Host; 413 where a body is announced; 414 and 431 beyond the limits above; 417
// for any expectation; 505 for another version than HTTP/1.0 and 1.1.
RequestHead parse_request_head(std::string_view text);

// The value of a field that was sent once; null where there is none or several. `name` is lower
// case.
const std::string* field_of(const RequestHead& head, std::string_view name);

// Whether the client may send another request on the same connection.
bool keeps_alive(const RequestHead& head);

// The value of a cookie; empty where it is absent or sent twice.
std::string_view cookie_of(const RequestHead& head, std::string_view name);

}  // namespace raywalk
