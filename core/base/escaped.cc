#include "core/base/escaped.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cctype>

namespace raywalk {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

// Length in bytes of the UTF-8 character at the front of `text`, which is not empty, by table 3-7
// of the Unicode standard; 0 if there is none.
std::size_t utf8_length(std::string_view text) {
  const unsigned lead = byte_at(text, 0);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte_at(text, i) & 0xC0U) != 0x80U) return 0;
  }
  // After some lead bytes the second has a narrower range: no overlong forms, no surrogates,
  // nothing beyond U+10FFFF.
  const unsigned second = byte_at(text, 1);
  const bool is_out_of_range = (lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) ||
                               (lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F);
  return is_out_of_range ? 0 : length;
}

// The code point of the UTF-8 character that `text` consists of.
unsigned code_point(std::string_view text) {
  if (text.size() == 1) return byte_at(text, 0);
  // The lead byte 110xxxxx, 1110xxxx or 11110xxx, then bytes 10xxxxxx.
  unsigned code = byte_at(text, 0) & (0x7FU >> text.size());
  for (std::size_t i = 1; i < text.size(); ++i) code = code << 6U | (byte_at(text, i) & 0x3FU);
  return code;
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

std::string shown(std::string_view character) {
  const unsigned code = code_point(character);
  if (!acts_on_text(code)) return std::string(character);
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
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      result += fmt::format("\\x{:02x}", byte_at(text, 0));
    } else {
      result += shown(text.substr(0, length));
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
