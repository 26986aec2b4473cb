#include "core/base/utf8.h"

#include <algorithm>

namespace raywalk {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

// By the lead byte; 0 for a byte that leads none.
std::size_t length_by_lead(unsigned lead) {
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  return lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
}

// Whether the bytes after the lead byte may follow it. The second byte has a narrower range after
// some lead bytes (overlong forms, surrogates, beyond U+10FFFF).
bool may_follow(std::string_view text) {
  for (std::size_t i = 1; i < text.size(); ++i) {
    if ((byte_at(text, i) & 0xC0U) != 0x80U) return false;
  }
  if (text.size() < 2) return true;
  const unsigned lead = byte_at(text, 0), second = byte_at(text, 1);
  return !(lead == 0xE0 && second < 0xA0) && !(lead == 0xED && second > 0x9F) &&
         !(lead == 0xF0 && second < 0x90) && !(lead == 0xF4 && second > 0x8F);
}

}  // namespace

std::size_t utf8_length(std::string_view text) {
  const std::size_t length = length_by_lead(byte_at(text, 0));
  return text.size() >= length && may_follow(text.substr(0, length)) ? length : 0;
}

bool is_part_of_utf8(std::string_view text) {
  return !text.empty() && text.size() < length_by_lead(byte_at(text, 0)) && may_follow(text);
}

char32_t utf8_code_point(std::string_view text) {
  if (text.size() == 1) return byte_at(text, 0);
  // The lead byte 110xxxxx, 1110xxxx or 11110xxx, then bytes 10xxxxxx.
  char32_t code = byte_at(text, 0) & (0x7FU >> text.size());
  for (std::size_t i = 1; i < text.size(); ++i) code = code << 6U | (byte_at(text, i) & 0x3FU);
  return code;
}

}  // namespace raywalk
