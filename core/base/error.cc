#include "core/base/error.h"

#include "core/base/escaped.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxExcerptBytes = 60;

bool is_space(unsigned char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

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
    line += c;
  }
  return escaped(line);
}

std::string excerpt(std::string_view text) {
  std::string line = escaped(text);
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
