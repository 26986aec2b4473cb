#include "core/base/escaped.h"

#include <spdlog/fmt/fmt.h>

#include "core/base/utf8.h"

namespace raywalk {
namespace {

bool acts_on_text(char32_t code) {
  const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  // Line and paragraph separators; marks, embeddings, overrides and isolates of the direction of
  // writing (Unicode standard annex 9).
  const bool breaks_lines = code == 0x2028 || code == 0x2029;
  const bool turns = code == 0x061C || code == 0x200E || code == 0x200F ||
                     (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return is_control || breaks_lines || turns;
}

std::string shown(std::string_view character, LineBreaks breaks) {
  const char32_t code = utf8_code_point(character);
  const bool keeps = breaks == LineBreaks::kKeep && (code == '\n' || code == '\t');
  if (keeps || !acts_on_text(code)) return std::string(character);
  if (code == '\n') return "\\n";
  if (code == '\r') return "\\r";
  if (code == '\t') return "\\t";
  return fmt::format("\\u{:04x}", static_cast<unsigned>(code));
}

}  // namespace

std::string escaped(std::string_view text, LineBreaks breaks) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
      text.remove_prefix(1);
    } else {
      result += shown(text.substr(0, length), breaks);
      text.remove_prefix(length);
    }
  }
  return result;
}

}  // namespace raywalk
