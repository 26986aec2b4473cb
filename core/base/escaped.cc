#include "core/base/escaped.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cctype>

namespace raywalk {
namespace {

struct Character {
  unsigned code = 0;       // its code point
  std::size_t length = 0;  // in bytes; 0: none
};

// The UTF-8 character at the front of `text`, which is not empty (RFC 3629).
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  // 110xxxxx, 1110xxxx or 11110xxx, then bytes 10xxxxxx.
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (lead < 0xC0 || lead >= 0xF8 || text.size() < length) return {};
  unsigned code = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return {};
    code = code << 6U | (byte(i) & 0x3FU);
  }
  const unsigned least = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;  // else overlong
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < least || is_surrogate || code > 0x10FFFF) return {};
  return {code, length};
}

bool acts_on_text(unsigned code) {
  const bool is_control = code < 0x20 || (code >= 0x7F && code < 0xA0);
  // Line and paragraph separators; marks, embeddings, overrides and isolates of the direction of
  // writing (Unicode standard annex 9).
  const bool breaks_lines = code == 0x2028 || code == 0x2029;
  const bool turns = code == 0x061C || code == 0x200E || code == 0x200F ||
                     (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return is_control || breaks_lines || turns;
}

std::string escape_of(unsigned code) {
  if (code == '\n') return "\\n";
  if (code == '\r') return "\\r";
  if (code == '\t') return "\\t";
  return fmt::format("\\u{:04x}", code);
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const auto [code, length] = first_of(text);
    if (length == 0) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else if (acts_on_text(code)) {
      result += escape_of(code);
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result;
}

std::string shell_word(std::string_view name) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_./-+=:,@%").find(c) != std::string_view::npos;
  };
  if (!name.empty() && std::ranges::all_of(name, is_plain)) return std::string(name);
  std::string word = "'";
  for (const char c : name) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace raywalk
