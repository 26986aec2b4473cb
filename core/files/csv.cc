#include "core/files/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
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

constexpr const char* kDecimalPoints = "write decimals with a point (0.5, not 0,5)";

// A number such as 0,5 or 1.234,5.
bool has_decimal_comma(const std::string& field) {
  return field.find(',') != std::string::npos &&
         field.find_first_not_of("+-.,0123456789") == std::string::npos;
}

// The name of a separator other than the comma that the fields hold; none if they hold none.
std::optional<std::string> other_separator(const std::vector<std::string>& fields) {
  const auto holds = [&](char separator) {
    return std::any_of(fields.begin(), fields.end(), [&](const std::string& field) {
      return field.find(separator) != std::string::npos;
    });
  };
  if (holds(';')) return "semicolons";
  if (holds('\t')) return "tabs";
  return std::nullopt;
}

std::string use_commas(const std::string& separators) {
  return fmt::format("its fields are separated by {}; separate them by commas and {}", separators,
                     kDecimalPoints);
}

// What is wrong with a record of another number of fields than the header, and what to do.
std::string wrong_count(const std::vector<std::string>& fields,
                        const std::vector<std::string>& columns) {
  const auto separators = other_separator(fields);
  if (separators && fields.size() < columns.size()) return use_commas(*separators);
  std::string count = fmt::format("{} fields where the header has {} ({})", fields.size(),
                                  columns.size(), joined(columns));
  if (fields.size() < columns.size()) return count;
  return fmt::format("{}; {}, and put a field that holds a comma in quotes", count, kDecimalPoints);
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
      throw Error(fmt::format("{}:{}: {}", source, record.line,
                              wrong_count(record.fields, table.columns_)));
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
      if (const auto separators = other_separator({*column})) {
        throw Error(where + ": " + use_commas(*separators));
      }
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
  return parse(read_file_or_stdin(file), input_name(file), required, optional);
}

bool CsvTable::has_column(const std::string& column) const { return contains(columns_, column); }

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  return rows_.at(row)[index_of(columns_, column)];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& field = text(row, column);
  if (const auto value = parse_finite_number(field)) return *value;
  const auto separators = other_separator({field});
  const std::string advice = has_decimal_comma(field) ? fmt::format("; {}", kDecimalPoints)
                             : separators             ? "; " + use_commas(*separators)
                                                      : "";
  throw Error(where(row) + ": column '" + column + "': " + excerpt(field) +
              " is not a finite number" + advice);
}

std::string CsvTable::where(std::size_t row) const {
  return source_ + ":" + std::to_string(line_numbers_.at(row));
}

}  // namespace raywalk
