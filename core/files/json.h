// JSON files: their text, and reading what a program wrote and anything may have happened to since.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace raywalk {

// Indented, with a line break at its end. Numbers that are not finite are null; bytes that are not
// UTF-8, e.g. in the name of a file, are replaced.
std::string json_text(const nlohmann::ordered_json& document);

// A value of a document, which it keeps alive. All functions but has() and is_null()
// throw Error "SOURCE: PLACE: WHAT; ADVICE" where the value is missing, of another type or out of
// range, e.g. "poses.json: frames[2]: yaw_deg: null is not a number; solve the poses again".
class CheckedJson {
 public:
  // The root of a document. `source` is what errors name, as a rule the file; `advice` how the file
  // is made again, may be empty. Throws Error where the text is not JSON or nests deeper than 16
  // levels.
  static CheckedJson parse(const std::string& text, const std::string& source,
                           const std::string& advice = "");
  // The same from a file; throws Error as read_file as well.
  static CheckedJson read(const std::filesystem::path& file, const std::string& advice = "");

  [[noreturn]] void fail(const std::string& what) const;

  // Refuses a document whose format_version, an integer from 1 on, is above `newest`.
  void require_version(int newest) const;

  CheckedJson at(const std::string& key) const;  // of an object
  bool has(const std::string& key) const;        // whether it is an object with this key
  bool is_null() const;

  // Of an object, in the order of the document.
  std::vector<std::pair<std::string, CheckedJson>> members() const;
  std::vector<CheckedJson> items() const;  // of a list
  std::vector<CheckedJson> items(std::size_t count) const;

  std::string text() const;
  std::vector<std::string> texts() const;  // of a list
  bool boolean() const;
  // Never rounds or wraps: 2.5, 2.0 and what int cannot hold are refused.
  int integer(int min = std::numeric_limits<int>::min(),
              int max = std::numeric_limits<int>::max()) const;
  double number(double min = std::numeric_limits<double>::lowest(),
                double max = std::numeric_limits<double>::max()) const;

 private:
  struct Document;

  CheckedJson(std::shared_ptr<const Document> document, const nlohmann::ordered_json* value,
              std::string place)
      : document_(std::move(document)), value_(value), place_(std::move(place)) {}

  void require(bool is_right, const char* type) const;
  // fail() with the value itself before `what`, cut where it is long.
  [[noreturn]] void fail_as_found(const std::string& what) const;

  std::shared_ptr<const Document> document_;
  const nlohmann::ordered_json* value_;
  std::string place_;  // SOURCE: KEY: KEY[INDEX]
};

}  // namespace raywalk
