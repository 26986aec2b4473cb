#include "core/files/row_names.h"

#include <cstddef>
#include <set>

#include "core/base/error.h"

namespace raywalk {
namespace {

// File systems allow 255 bytes, including extension and suffix.
constexpr std::size_t kLongestName = 200;

bool is_file_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         name.find_first_of("/,\"\r\n") == std::string::npos;
}

}  // namespace

std::vector<std::string> file_names_of_rows(const CsvTable& table, const std::string& column) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& name = table.text(row, column);
    if (!is_file_name(name)) {
      throw Error(table.where(row) + ": the name " + excerpt(name) +
                  " is not a valid file name; use letters, digits, '_' and '-'");
    }
    if (!taken.insert(name).second) {
      throw Error(table.where(row) + ": the name " + excerpt(name) + " appears twice");
    }
    names.push_back(name);
  }
  return names;
}

}  // namespace raywalk
