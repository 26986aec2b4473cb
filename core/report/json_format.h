// A value of a JSON document as text for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace raywalk {

// Whether there is no figure: null, and numbers that are not finite, which JSON writes as null.
bool is_nothing(const nlohmann::ordered_json& value);

// `format` is one of
//   (none)             text as it is; a whole number; "yes" or "no"
//   .2f  +.2f  .3g  e  a number as printf writes it; zero has no sign
//   .1%                a share in percent: 0.25 is "25.0 %"
//   length             metres in mm below 1 cm, else in cm, with one decimal
//   counted line       a whole number, or the length of a list, and its noun: "1 line", "3 lines"
//   size               the length of a list
//   joined             the entries of a list, with commas
//   high|low           "high" if true, "low" if false
// What follows a number's format is its unit: ".1f px", " px", ".2f°". Nothing reads "–", without a
// unit, or what stands after a last '|': ".2f m|sky". Throws std::logic_error if the format is not
// one for such a value.
std::string formatted(const nlohmann::ordered_json& value, std::string_view format);

}  // namespace raywalk
