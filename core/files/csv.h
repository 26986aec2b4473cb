// Comma-separated tables with a header line, such as poses.csv, gt.csv and path.csv.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// One record and the line it starts on, counted from 1; a quoted field may span several lines.
struct CsvRecord {
  int line = 0;
  std::vector<std::string> fields;
};

// Splits the text (RFC 4180). Unquoted fields are trimmed; blank lines and lines that start with
// '#' are skipped; LF and CRLF end a line; a UTF-8 byte order mark is accepted. Throws Error with
// source and line: an unterminated quote, text after a quoted field, a quote inside an unquoted
// field, a NUL byte, a line behind the first that starts with '#', no blank, and could be a row.
std::vector<CsvRecord> split_csv(std::string_view text, const std::string& source);

// A table of such records, which may have no rows. `text` and `number` throw std::logic_error for a
// column the table does not have: check has_column for optional columns.
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
  void check_header(const std::vector<std::string>& required,
                    const std::vector<std::string>& optional) const;

  std::string source_;
  CsvRecord header_;
  std::vector<CsvRecord> rows_;
};

// A text as a field of such a table, in quotes where it needs them.
std::string csv_field(const std::string& text);

// The column of every row as names of output files, without extension. Throws Error with source and
// line for a name that is not usable as a file name or would need quotes in a table (empty, a
// leading dot, a slash, comma, quote or line break, over 200 bytes), or that occurs twice.
std::vector<std::string> file_names_of_rows(const CsvTable& table, const std::string& column);

}  // namespace raywalk
