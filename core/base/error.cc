#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxExcerptBytes = 60;

bool is_space(unsigned char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

bool is_control(unsigned char c) { return c < 0x20 || c == 0x7f; }

}  // namespace

std::string one_line(std::string_view text) {
  std::string line;
  bool space_pending = false;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (is_space(byte)) {
      space_pending = !line.empty();
      continue;
    }
    if (space_pending) line += ' ';
    space_pending = false;
    line += is_control(byte) ? '?' : c;
  }
  return line;
}

std::string excerpt(std::string_view text) {
  std::string line = one_line(text);
  if (line.size() > kMaxExcerptBytes) {
    // Cut between characters: bytes 10xxxxxx continue a UTF-8 character (RFC 3629).
    std::size_t cut = kMaxExcerptBytes;
    while (cut > 0 && (static_cast<unsigned char>(line[cut]) & 0xC0) == 0x80) --cut;
    line.resize(cut);
    line += "...";
  }
  return "'" + line + "'";
}

}  // namespace raywalk
