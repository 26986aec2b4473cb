#include "core/http/request_head.h"

#include <algorithm>

#include "core/http/field_text.h"
#include "core/http/http_fault.h"

namespace raywalk {
namespace {

constexpr std::string_view kLineEnd = "\r\n";

// RFC 9110, 5.6.2.
bool is_token(std::string_view text) {
  constexpr std::string_view kOthers = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    return is_letter || (c >= '0' && c <= '9') || kOthers.find(c) != std::string_view::npos;
  });
}

bool is_visible(char c) { return c > ' ' && c < '\x7f'; }

// Bytes above ASCII are allowed in values, control characters are not.
bool may_be_in_value(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte == '\t' || (byte >= 0x20 && byte != 0x7f);
}

// "HTTP/" and two digits with a dot between, RFC 9112, 2.3.
bool is_version(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return text.size() == 8 && text.starts_with("HTTP/") && is_digit(text[5]) && text[6] == '.' &&
         is_digit(text[7]);
}

void parse_request_line(std::string_view line, RequestHead* head) {
  if (line.size() > kMostRequestLine) throw HttpFault(414, "the address is too long");
  const std::string_view method = next_part(&line, " ");
  const std::string_view target = next_part(&line, " ");
  const std::string_view version = line;
  const bool has_target = !target.empty() && std::all_of(target.begin(), target.end(), is_visible);
  if (!is_token(method) || !has_target || !is_version(version)) {
    throw HttpFault(400, "the request line is not one of HTTP");
  }
  if (version != "HTTP/1.0" && version != "HTTP/1.1") {
    throw HttpFault(505, "only HTTP/1.0 and HTTP/1.1 are served");
  }
  head->method = method;
  head->target = target;
  head->minor_version = version.back() - '0';
}

RequestField parse_field(std::string_view line) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
    throw HttpFault(400, "a line of the request's head is not a field");
  }
  const std::string_view value = trimmed_field(line.substr(colon + 1));
  if (!std::all_of(value.begin(), value.end(), may_be_in_value)) {
    throw HttpFault(400, "a field of the request has control characters");
  }
  return {lower_case(line.substr(0, colon)), std::string(value)};
}

std::ptrdiff_t count_of(const RequestHead& head, std::string_view name) {
  return std::count_if(head.fields.begin(), head.fields.end(),
                       [&](const RequestField& field) { return field.name == name; });
}

void require_no_body(const RequestHead& head) {
  const std::ptrdiff_t lengths = count_of(head, "content-length");
  const std::string* length = field_of(head, "content-length");
  const bool is_empty = lengths == 0 || (length != nullptr && *length == "0");
  if (!is_empty || count_of(head, "transfer-encoding") > 0) {
    throw HttpFault(413, "requests with a body are not accepted");
  }
}

}  // namespace

RequestHead parse_request_head(std::string_view text) {
  RequestHead head;
  const std::size_t size = text.size();
  parse_request_line(next_part(&text, kLineEnd), &head);
  if (size > kMostRequestHead) throw HttpFault(431, "the head of the request is too long");
  while (!text.empty()) {
    const std::string_view line = next_part(&text, kLineEnd);
    if (line.empty()) break;
    if (head.fields.size() == kMostRequestFields) {
      throw HttpFault(431, "the request has too many fields");
    }
    head.fields.push_back(parse_field(line));
  }
  const std::ptrdiff_t hosts = count_of(head, "host");
  if (hosts > 1 || (hosts == 0 && head.minor_version > 0)) {
    throw HttpFault(400, "the request must have one Host");
  }
  require_no_body(head);
  if (count_of(head, "expect") > 0) throw HttpFault(417, "no expectation is met");
  return head;
}

const std::string* field_of(const RequestHead& head, std::string_view name) {
  if (count_of(head, name) != 1) return nullptr;
  return &std::find_if(head.fields.begin(), head.fields.end(), [&](const RequestField& field) {
            return field.name == name;
          })->value;
}

bool keeps_alive(const RequestHead& head) {
  if (head.minor_version == 0) return false;
  for (const RequestField& field : head.fields) {
    if (field.name != "connection") continue;
    std::string_view options = field.value;
    while (!options.empty()) {
      if (lower_case(trimmed_field(next_part(&options, ","))) == "close") return false;
    }
  }
  return true;
}

std::string_view cookie_of(const RequestHead& head, std::string_view name) {
  std::string_view found;
  int count = 0;
  for (const RequestField& field : head.fields) {
    if (field.name != "cookie") continue;
    std::string_view cookies = field.value;
    while (!cookies.empty()) {
      std::string_view value = trimmed_field(next_part(&cookies, ";"));
      if (next_part(&value, "=") != name) continue;
      found = value;
      ++count;
    }
  }
  return count == 1 ? found : std::string_view();
}

}  // namespace raywalk
