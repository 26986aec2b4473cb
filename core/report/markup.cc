#include "core/report/markup.h"

#include "core/base/escaped.h"

namespace raywalk {
namespace {

std::string_view escaped_ascii(const char& character) {
  switch (character) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {&character, 1};
  }
}

}  // namespace

std::string escape_markup(std::string_view text) {
  std::string markup;
  markup.reserve(text.size());
  for (const char& character : escaped(text)) markup += escaped_ascii(character);
  return markup;
}

}  // namespace raywalk
