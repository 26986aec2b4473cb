#include "core/http/request_target.h"

#include <algorithm>

#include "core/http/field_text.h"
#include "core/http/http_fault.h"

namespace raywalk {
namespace {

[[noreturn]] void refuse(const std::string& sentence) { throw HttpFault(400, sentence); }

// -1 where it is none.
int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string decoded(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
    if (low < 0) refuse("an escape of the address is not two hexadecimal digits");
    result += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return result;
}

// As forms write it: a plus is a space.
std::string decoded_form(std::string_view text) {
  std::string spaced(text);
  std::replace(spaced.begin(), spaced.end(), '+', ' ');
  return decoded(spaced);
}

bool may_be_in_segment(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte >= 0x20 && byte != 0x7f && c != '/' && c != '\\';
}

std::string decoded_path(std::string_view written) {
  std::string path;
  while (!written.empty()) {
    written.remove_prefix(1);  // the slash
    const std::size_t end = std::min(written.find('/'), written.size());
    const std::string segment = decoded(written.substr(0, end));
    written.remove_prefix(end);
    const bool is_name = !segment.empty() || written.empty();
    if (!is_name || segment == "." || segment == ".." ||
        !std::all_of(segment.begin(), segment.end(), may_be_in_segment)) {
      refuse("the path of the address is not one of a file here");
    }
    path += '/' + segment;
  }
  return path;
}

QueryParameter parse_parameter(std::string_view written) {
  std::string_view value = written;
  const std::string_view name = next_part(&value, "=");
  return {decoded_form(name), decoded_form(value), std::string(written)};
}

}  // namespace

RequestTarget parse_request_target(std::string_view target) {
  const auto is_visible = [](char c) { return c > ' ' && c < '\x7f' && c != '#'; };
  if (!target.starts_with('/') || !std::all_of(target.begin(), target.end(), is_visible)) {
    refuse("the address must begin with its path");
  }
  std::string_view query = target;
  RequestTarget result;
  result.written_path = next_part(&query, "?");
  result.path = decoded_path(result.written_path);
  while (!query.empty()) {
    const std::string_view written = next_part(&query, "&");
    if (written.empty()) continue;
    if (result.query.size() == kMostQueryParameters) refuse("the address has too many parameters");
    result.query.push_back(parse_parameter(written));
  }
  return result;
}

std::optional<std::string> parameter_of(const RequestTarget& target, std::string_view name) {
  std::optional<std::string> found;
  for (const QueryParameter& parameter : target.query) {
    if (parameter.name != name) continue;
    if (found) refuse("the parameter " + std::string(name) + " is given twice; give it once");
    found = parameter.value;
  }
  return found;
}

std::string target_without(const RequestTarget& target, std::string_view name) {
  std::string result = target.written_path;
  char separator = '?';
  for (const QueryParameter& parameter : target.query) {
    if (parameter.name == name) continue;
    result += separator + parameter.written;
    separator = '&';
  }
  return result;
}

}  // namespace raywalk
