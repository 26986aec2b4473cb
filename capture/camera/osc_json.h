// Members of a JSON object that a camera sent, which may be missing or of any type.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace raywalk::capture {

// Empty where there is no text.
std::string text_at(const nlohmann::json& object, const char* key);
// None where there is no number.
std::optional<double> number_at(const nlohmann::json& object, const char* key);
// None where there is no number from 0 to 2^53; decimals are cut off.
std::optional<std::int64_t> count_at(const nlohmann::json& object, const char* key);

}  // namespace raywalk::capture
