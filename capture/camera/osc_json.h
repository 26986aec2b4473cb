// Members of a JSON object from a camera, which may be missing or of any type.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace raywalk::capture {

// Empty if it is not a text.
std::string text_at(const nlohmann::json& object, const char* key);
// None if it is not a number.
std::optional<double> number_at(const nlohmann::json& object, const char* key);
// None if it is not a number from 0 to 2^53; truncated to a whole number.
std::optional<std::int64_t> count_at(const nlohmann::json& object, const char* key);

}  // namespace raywalk::capture
