#include "render/web/hotspots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "core/files/frame_list.h"
#include "core/files/json.h"

namespace raywalk::render {
namespace {

constexpr std::array<std::string_view, 5> kKeys{"x_m", "y_m", "z_m", "text", "link"};

// A browser runs a link with another scheme ("javascript:"), and ignores spaces and control
// characters before and in a scheme; "//host" is another host.
bool is_harmless(const std::string& link) {
  const bool has_spaces = std::ranges::any_of(
      link, [](unsigned char c) { return std::isspace(c) != 0 || std::iscntrl(c) != 0; });
  if (link.empty() || has_spaces) return false;
  std::string lower = link;
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (lower.starts_with("http://") || lower.starts_with("https://")) return true;
  const std::string first_part = lower.substr(0, lower.find_first_of("/?#"));
  return first_part.find(':') == std::string::npos && !lower.starts_with("//") &&
         lower.find('\\') == std::string::npos;
}

std::string link_of(const CheckedJson& entry) {
  if (!entry.has("link")) return {};
  const CheckedJson link = entry.at("link");
  std::string text = link.text();
  if (!is_harmless(text)) link.fail("is neither an http or https address nor a relative path");
  return text;
}

double metres_of(const CheckedJson& entry, const std::string& key) {
  return entry.at(key).number(-kMaxPosition_m, kMaxPosition_m);
}

Hotspot hotspot_of(const CheckedJson& entry) {
  for (const auto& [key, value] : entry.members()) {
    if (std::ranges::find(kKeys, key) == kKeys.end()) {
      value.fail("unknown key; a hotspot has x_m, y_m, z_m, text and link");
    }
  }
  const CheckedJson text = entry.at("text");
  Hotspot hotspot{
      .position_m = {metres_of(entry, "x_m"), metres_of(entry, "y_m"), metres_of(entry, "z_m")},
      .text = text.text(),
      .link = link_of(entry)};
  if (hotspot.text.empty()) text.fail("is empty");
  return hotspot;
}

}  // namespace

std::vector<Hotspot> read_hotspots(const std::filesystem::path& file) {
  std::vector<Hotspot> hotspots;
  for (const CheckedJson& entry : CheckedJson::read(file).items()) {
    hotspots.push_back(hotspot_of(entry));
  }
  return hotspots;
}

}  // namespace raywalk::render
