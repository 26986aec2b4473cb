#include "core/command_line/completion_text.h"

#include <algorithm>

namespace raywalk {

std::string short_description(const std::string& description) {
  std::size_t end = description.size();
  for (const char* mark : {"; ", " (", ": "}) end = std::min(end, description.find(mark));
  return description.substr(0, end);
}

}  // namespace raywalk
