// For tests: checks that a page or plot is well-formed.
#pragma once

#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// The first error in `markup` as XML, or an empty string: mismatched tags, unquoted attributes,
// stray '<' or '&', or text outside the root element. Style sheets are skipped.
inline std::string markup_fault(std::string_view markup) {
  std::vector<std::string> open;
  std::size_t at = 0;
  bool had_root = false;
  const auto fault = [&](const std::string& what) {
    return what + " at byte " + std::to_string(at) + ": " + std::string(markup.substr(at, 60));
  };
  while (at < markup.size()) {
    const char c = markup[at];
    if (c == '&') {
      const std::size_t end = markup.find(';', at);
      if (end == std::string_view::npos || end - at > 6) return fault("stray '&'");
    }
    if (c != '<') {
      if (open.empty() && std::isspace(static_cast<unsigned char>(c)) == 0) {
        return fault("text outside the root");
      }
      ++at;
      continue;
    }
    // The end of the tag, outside of quotes.
    std::size_t end = at + 1;
    bool quoted = false;
    while (end < markup.size() && (quoted || markup[end] != '>')) {
      if (markup[end] == '"') quoted = !quoted;
      if (markup[end] == '<') return fault("stray '<'");
      if (markup[end] == '=' && !quoted && markup.substr(end + 1, 1) != "\"") {
        return fault("unquoted attribute");
      }
      ++end;
    }
    if (end >= markup.size()) return fault("unfinished tag");
    const std::string tag(markup.substr(at + 1, end - at - 1));
    const std::string name = tag.substr(0, tag.find_first_of(" \n/", 1));
    if (tag.starts_with('!')) {
      if (had_root) return fault("declaration after the root");
    } else if (tag.starts_with('/')) {
      if (open.empty() || "/" + open.back() != tag) return fault("mismatched tag");
      open.pop_back();
    } else {
      if (open.empty() && had_root) return fault("second root");
      had_root = true;
      if (!tag.ends_with('/')) open.push_back(name);
    }
    at = end + 1;
    if (tag == "style") at = markup.find("</style>", at);
  }
  if (!open.empty()) return "unclosed <" + open.back() + ">";
  return had_root ? "" : "no element";
}

}  // namespace raywalk
