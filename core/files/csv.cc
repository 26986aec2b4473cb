#include "core/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv_records.h"
#include "core/files/nearest_word.h"
#include "core/files/number.h"

namespace raywalk {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ",") + word;
  return list;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::size_t index_of(const std::vector<std::string>& columns, const std::string& column) {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) throw std::logic_error("no column '" + column + "' in this table");
  return static_cast<std::size_t>(found - columns.begin());
}

}  // namespace

CsvTable CsvTable::parse(std::string_view text, const std::string& source,
                         const std::vector<std::string>& required,
                         const std::vector<std::string>& optional) {
  std::vector<CsvRecord> records = split_csv(text, source);
  if (records.empty()) {
    throw Error(source + ": empty; a header line with " + joined(required) + " is needed");
  }
  CsvTable table;
  table.source_ = source;
  table.set_columns(std::move(records.front().fields),
                    source + ":" + std::to_string(records.front().line), required, optional);
  for (std::size_t i = 1; i < records.size(); ++i) {
    CsvRecord& record = records[i];
    if (record.fields.size() != table.columns_.size()) {
      throw Error(source + ":" + std::to_string(record.line) + ": " +
                  std::to_string(record.fields.size()) + " fields where the header has " +
                  std::to_string(table.columns_.size()) + " (" + joined(table.columns_) + ")");
    }
    table.line_numbers_.push_back(record.line);
    table.rows_.push_back(std::move(record.fields));
  }
  return table;
}

void CsvTable::set_columns(std::vector<std::string> columns, const std::string& where,
                           const std::vector<std::string>& required,
                           const std::vector<std::string>& optional) {
  std::vector<std::string> valid = required;
  valid.insert(valid.end(), optional.begin(), optional.end());
  for (auto column = columns.begin(); column != columns.end(); ++column) {
    if (!contains(valid, *column)) {
      throw Error(where + ": unknown column " + excerpt(*column) + suggestion(*column, valid));
    }
    if (std::find(columns.begin(), column, *column) != column) {
      throw Error(where + ": column '" + *column + "' appears twice");
    }
  }
  for (const std::string& column : required) {
    if (!contains(columns, column)) {
      throw Error(
          fmt::format("{}: no column '{}'; the header needs {}", where, column, joined(required)));
    }
  }
  columns_ = std::move(columns);
}

CsvTable CsvTable::read(const std::filesystem::path& file, const std::vector<std::string>& required,
                        const std::vector<std::string>& optional) {
  return parse(read_file(file), file.string(), required, optional);
}

bool CsvTable::has_column(const std::string& column) const { return contains(columns_, column); }

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  return rows_.at(row)[index_of(columns_, column)];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& field = text(row, column);
  if (const auto value = parse_finite_number(field)) return *value;
  throw Error(where(row) + ": column '" + column + "': " + excerpt(field) +
              " is not a finite number");
}

std::string CsvTable::where(std::size_t row) const {
  return source_ + ":" + std::to_string(line_numbers_.at(row));
}

}  // namespace raywalk
