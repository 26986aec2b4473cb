// Comma-separated tables with a header line, as poses.csv, gt.csv and path.csv are.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// A parsed table. Fields are trimmed; quoted fields ("a, ""b""") follow RFC 4180; blank lines and
// lines that start with '#' are skipped; CRLF and a UTF-8 byte order mark are accepted. The table
// may have no rows. `text` and `number` throw std::logic_error for a column the table does not
// have: ask has_column first where a column is optional.
class CsvTable {
 public:
  // `source` names the text in errors. `required` columns must be there, `optional` may be, any
  // other is an error that names the nearest valid column. Throws Error with source and line.
  static CsvTable parse(std::string_view text, const std::string& source,
                        const std::vector<std::string>& required,
                        const std::vector<std::string>& optional);
  static CsvTable read(const std::filesystem::path& file, const std::vector<std::string>& required,
                       const std::vector<std::string>& optional);

  std::size_t rows() const { return rows_.size(); }
  bool has_column(const std::string& column) const;
  const std::string& text(std::size_t row, const std::string& column) const;
  // A finite number; throws Error with source, line and column if it is none.
  double number(std::size_t row, const std::string& column) const;
  // "poses.csv:12", for errors found later.
  std::string where(std::size_t row) const;

 private:
  void set_columns(std::vector<std::string> columns, const std::string& where,
                   const std::vector<std::string>& required,
                   const std::vector<std::string>& optional);

  std::string source_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<int> line_numbers_;
};

}  // namespace raywalk
