// Comma-separated tables with a header line, such as poses.csv, gt.csv and path.csv.
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
// have: check has_column for optional columns.
class CsvTable {
 public:
  // `source` names the text in errors. Columns in `required` must be present, those in `optional`
  // may be; any other column is an error that suggests the nearest valid one. Throws Error with
  // source and line.
  static CsvTable parse(std::string_view text, const std::string& source,
                        const std::vector<std::string>& required,
                        const std::vector<std::string>& optional);
  // The same of a file, "-" for standard input.
  static CsvTable read(const std::filesystem::path& file, const std::vector<std::string>& required,
                       const std::vector<std::string>& optional);

  std::size_t rows() const { return rows_.size(); }
  bool has_column(const std::string& column) const;
  const std::string& text(std::size_t row, const std::string& column) const;
  // A finite number; throws Error with source, line and column if the field is not one.
  double number(std::size_t row, const std::string& column) const;
  // "poses.csv:12", for error messages.
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
