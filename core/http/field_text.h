// Pieces of the text of requests.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

// Without the spaces and tabs around it (OWS of RFC 9110, 5.6.3).
std::string_view trimmed_field(std::string_view text);

// ASCII letters in lower case, whatever the locale.
std::string lower_case(std::string_view text);

// The text up to the next `separator`, or all of it; removes both from `rest`.
std::string_view next_part(std::string_view* rest, std::string_view separator);

}  // namespace raywalk
