#include "capture/camera/osc_json.h"

#include <nlohmann/json.hpp>

namespace raywalk::capture {

std::string text_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

std::optional<double> number_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

// A whole number from 0 to what a double holds exactly; none for anything else.
std::optional<std::int64_t> count_at(const nlohmann::json& object, const char* key) {
  constexpr double kLargest = 9007199254740992.0;  // 2^53
  const auto number = number_at(object, key);
  if (!number || !(*number >= 0.0 && *number <= kLargest)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

}  // namespace raywalk::capture
