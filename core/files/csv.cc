#include "core/files/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kBlank = " \t\r";
constexpr const char* kDecimalPoints = "write decimals with a point (0.5, not 0,5)";
// File systems allow 255 bytes, including extension and suffix.
constexpr std::size_t kLongestName = 200;

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

// A cursor over the text; each function consumes the element it is named after.
class CsvSplitter {
 public:
  CsvSplitter(std::string_view text, const std::string& source) : rest_(text), source_(source) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    if (rest_.find('\0') != std::string_view::npos) {
      throw Error(source_ + ": holds binary data; a table of comma-separated text is needed");
    }
  }

  std::vector<CsvRecord> records() {
    std::vector<CsvRecord> records;
    for (; !rest_.empty(); ++line_) {
      const std::string_view line = rest_.substr(0, rest_.find('\n'));
      if (line.starts_with('#') || trimmed(line).empty()) {
        if (!records.empty()) require_comment(line, records.front());
        rest_.remove_prefix(line.size());
      } else {
        CsvRecord& record = records.emplace_back(CsvRecord{line_, {field()}});
        while (skip(',')) record.fields.push_back(field());
      }
      skip('\n');
    }
    return records;
  }

 private:
  // Names of files may begin with '#': a row of one would be left out without a word.
  void require_comment(std::string_view line, const CsvRecord& header) const {
    const auto fields = static_cast<std::size_t>(std::ranges::count(line, ',')) + 1;
    if (!line.starts_with('#') || line.starts_with("# ") || fields != header.fields.size()) return;
    fail(
        "begins with '#' but has as many fields as a row; put a name that begins so in quotes, or "
        "a blank behind the '#' of a comment");
  }

  // Up to the next comma, line end or end of text.
  std::string field() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlank), rest_.size()));
    if (skip('"')) return quoted_field();
    const std::string_view field = rest_.substr(0, rest_.find_first_of(",\n"));
    if (field.find('"') != std::string_view::npos) {
      fail("a quote inside an unquoted field; put the whole field in quotes and double the quote");
    }
    rest_.remove_prefix(field.size());
    return std::string(trimmed(field));
  }

  // A doubled quote is an escaped quote (RFC 4180, section 2, rule 7).
  std::string quoted_field() {
    std::string field(up_to_quote());
    while (skip('"')) field.append("\"").append(up_to_quote());
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlank), rest_.size()));
    if (!rest_.empty() && !rest_.starts_with(',') && !rest_.starts_with('\n')) {
      fail("text after a quoted field; a comma is needed between fields");
    }
    return field;
  }

  // The text before the next quote, which is consumed too.
  std::string_view up_to_quote() {
    const std::string_view text = rest_.substr(0, rest_.find('"'));
    if (text.size() == rest_.size()) fail("a quoted field has no closing quote");
    line_ += static_cast<int>(std::ranges::count(text, '\n'));
    rest_.remove_prefix(text.size() + 1);
    return text;
  }

  bool skip(char c) {
    const bool is_next = rest_.starts_with(c);
    if (is_next) rest_.remove_prefix(1);
    return is_next;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}:{}: {}", source_, line_, what));
  }

  std::string_view rest_;
  const std::string& source_;
  int line_ = 1;
};

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::ranges::find(words, word) != words.end();
}

// What to do about a separator other than the comma that the text holds; empty if it holds none.
std::string other_separator(const std::string& text) {
  const std::size_t found = text.find_first_of(";\t");
  if (found == std::string::npos) return "";
  return fmt::format("its fields are separated by {}; separate them by commas and {}",
                     text[found] == ';' ? "semicolons" : "tabs", kDecimalPoints);
}

// What is wrong with a record of another number of fields than the header, and what to do.
std::string wrong_count(const std::vector<std::string>& fields,
                        const std::vector<std::string>& columns) {
  const bool too_few = fields.size() < columns.size();
  std::string separator = other_separator(fmt::format("{}", fmt::join(fields, ",")));
  if (too_few && !separator.empty()) return separator;
  std::string count = fmt::format("{} fields where the header has {} ({})", fields.size(),
                                  columns.size(), fmt::join(columns, ","));
  if (too_few) return count;
  return fmt::format("{}; {}, and put a field that holds a comma in quotes", count, kDecimalPoints);
}

// What to do about a field that is no number.
std::string number_advice(const std::string& field) {
  const bool decimal_comma = field.find(',') != std::string::npos &&
                             field.find_first_not_of("+-.,0123456789") == std::string::npos;
  const std::string advice = decimal_comma ? kDecimalPoints : other_separator(field);
  return advice.empty() ? "" : "; " + advice;
}

bool is_file_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         name.find_first_of("/,\"\r\n") == std::string::npos;
}

}  // namespace

std::vector<CsvRecord> split_csv(std::string_view text, const std::string& source) {
  return CsvSplitter(text, source).records();
}

CsvTable CsvTable::parse(std::string_view text, const std::string& source,
                         const std::vector<std::string>& required,
                         const std::vector<std::string>& optional) {
  CsvTable table;
  table.source_ = source;
  table.rows_ = split_csv(text, source);
  if (table.rows_.empty()) {
    throw Error(fmt::format("{}: empty; a header line with {} is needed", source,
                            fmt::join(required, ",")));
  }
  table.header_ = std::move(table.rows_.front());
  table.rows_.erase(table.rows_.begin());
  table.check_header(required, optional);
  const std::vector<std::string>& columns = table.header_.fields;
  for (const CsvRecord& row : table.rows_) {
    if (row.fields.size() == columns.size()) continue;
    throw Error(fmt::format("{}:{}: {}", source, row.line, wrong_count(row.fields, columns)));
  }
  return table;
}

CsvTable CsvTable::read(const std::filesystem::path& file, const std::vector<std::string>& required,
                        const std::vector<std::string>& optional) {
  std::error_code error;
  if (file != "-" && !std::filesystem::exists(file, error)) {
    throw Error(fmt::format("{}: no such file; give a table with the columns {}", file.string(),
                            fmt::join(required, ",")));
  }
  return parse(read_file_or_stdin(file), input_name(file), required, optional);
}

void CsvTable::check_header(const std::vector<std::string>& required,
                            const std::vector<std::string>& optional) const {
  const auto fail = [&](const std::string& what) {
    throw Error(fmt::format("{}:{}: {}", source_, header_.line, what));
  };
  std::vector<std::string> valid = required;
  valid.insert(valid.end(), optional.begin(), optional.end());
  for (const std::string& column : header_.fields) {
    if (!contains(valid, column)) {
      const std::string separator = other_separator(column);
      fail(separator.empty() ? "unknown column " + excerpt(column) + suggestion(column, valid)
                             : separator);
    }
    if (std::ranges::count(header_.fields, column) > 1) {
      fail("column '" + column + "' appears twice");
    }
  }
  for (const std::string& column : required) {
    if (contains(header_.fields, column)) continue;
    fail(fmt::format("no column '{}'; the header needs {}", column, fmt::join(required, ",")));
  }
}

bool CsvTable::has_column(const std::string& column) const {
  return contains(header_.fields, column);
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  const auto found = std::ranges::find(header_.fields, column);
  if (found == header_.fields.end()) {
    throw std::logic_error("no column '" + column + "' in this table");
  }
  return rows_.at(row).fields[static_cast<std::size_t>(found - header_.fields.begin())];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& field = text(row, column);
  if (const auto value = parse_finite_number(field)) return *value;
  throw Error(fmt::format("{}: column '{}': {} is not a finite number{}", where(row), column,
                          excerpt(field), number_advice(field)));
}

std::string CsvTable::where(std::size_t row) const {
  return source_ + ":" + std::to_string(rows_.at(row).line);
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos && !text.starts_with('#') &&
      !text.starts_with(' ')) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::vector<std::string> file_names_of_rows(const CsvTable& table, const std::string& column) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& name = names.emplace_back(table.text(row, column));
    if (!is_file_name(name)) {
      throw Error(table.where(row) + ": the name " + excerpt(name) +
                  " is not a valid file name; use letters, digits, '_' and '-'");
    }
    if (!taken.insert(name).second) {
      throw Error(table.where(row) + ": the name " + excerpt(name) + " appears twice");
    }
  }
  return names;
}

}  // namespace raywalk
