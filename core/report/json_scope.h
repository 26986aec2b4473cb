// Texts, numbers and conditions from a JSON document, for reports.
//
// A path names a value by its keys: "truth.maps"; "position_m.0" is an entry of a list, and "." the
// value at hand. Paths start at the part of the document at hand, those with "/" in front at its
// root, those with "^" at the object around the part: "^id" in an entry of "lines.models" is the
// id of its line.
//
// A path that does not exist is an error of the program, as is what cannot be made of the value:
// all functions throw std::logic_error then, so that the test of a page finds a renamed key.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// A part of a document, which has to outlive it.
class JsonScope {
 public:
  explicit JsonScope(const nlohmann::ordered_json& document);

  const nlohmann::ordered_json& value(std::string_view path) const;
  JsonScope at(std::string_view path) const;
  // The entries of a list; of all of them where the path leads through lists: "lines.models". None
  // of null.
  std::vector<JsonScope> entries(std::string_view path) const;

  // A number: "PATH", "PATH / PATH", or "PATH as cm" (from metres) and "PATH as MB" (from bytes).
  // NaN for null.
  double number(std::string_view expression) const;

  // A condition: "PATH" (neither null nor false, zero or empty), "PATH > PATH" (also <, >= and <=;
  // false where one of them is null), "PATH is TEXT", or "!" and a condition.
  bool holds(std::string_view expression) const;

  // The text with its placeholders filled: "{PATH}" or "{PATH:FORMAT}", with formats as
  // formatted() takes (json_format.h); in place of the path a number or a condition as above, e.g.
  // "{bytes as MB:.1f MB}" and "{before < after:better|worse}". "{{" and "}}" are braces.
  std::string text(std::string_view text) const;

 private:
  // The scope at which a path starts; cuts what says so off the path.
  JsonScope start_of(std::string_view* path) const;
  void enter(std::string_view key, std::string_view path);
  static std::vector<JsonScope> entries_of(const std::vector<JsonScope>& lists);
  std::string placeholder(std::string_view expression, std::string_view format) const;

  // The values around the part at hand, from the root to it.
  std::vector<const nlohmann::ordered_json*> levels_;
};

}  // namespace raywalk
