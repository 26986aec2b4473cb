#include "core/base/error.h"

#include <sstream>

#include "core/base/escaped.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxExcerptBytes = 60;

}  // namespace

std::string one_line(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string line;
  for (std::string word; words >> word;) line += (line.empty() ? "" : " ") + word;
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
