// Text inside HTML and SVG.
#pragma once

#include <string>
#include <string_view>

#include "core/base/number_text.h"

namespace raywalk {

// Escapes `text` for use between tags and in quoted attributes of HTML and XML: the five special
// characters become references; control characters and bytes that are not UTF-8 are shown as
// escaped() shows them (escaped.h), so that any file name keeps a page well-formed and on one line.
std::string escape_markup(std::string_view text);

}  // namespace raywalk
