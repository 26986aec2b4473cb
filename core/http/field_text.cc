#include "core/http/field_text.h"

#include <algorithm>

namespace raywalk {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t'; }

}  // namespace

std::string_view trimmed_field(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

std::string_view next_part(std::string_view* rest, std::string_view separator) {
  const std::size_t end = rest->find(separator);
  const std::string_view part = rest->substr(0, end);
  rest->remove_prefix(end == std::string_view::npos ? rest->size() : end + separator.size());
  return part;
}

}  // namespace raywalk
