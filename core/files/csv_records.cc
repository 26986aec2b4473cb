#include "core/files/csv_records.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"

namespace raywalk {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kBlank = " \t\r";

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
    while (!rest_.empty()) {
      const std::string_view line = rest_.substr(0, rest_.find('\n'));
      if (line.starts_with('#') || trimmed(line).empty()) {
        skip(line.size());
        end_line();
      } else {
        records.push_back(record());
      }
    }
    return records;
  }

 private:
  CsvRecord record() {
    CsvRecord record;
    record.line = line_;
    record.fields.push_back(field());
    while (rest_.starts_with(',')) {
      skip(1);
      record.fields.push_back(field());
    }
    end_line();
    return record;
  }

  // Up to the next comma, line end or end of text.
  std::string field() {
    skip_blanks();
    return rest_.starts_with('"') ? quoted_field() : unquoted_field();
  }

  std::string unquoted_field() {
    const std::string_view field = rest_.substr(0, rest_.find_first_of(",\n"));
    if (field.find('"') != std::string_view::npos) {
      fail("a quote inside an unquoted field; put the whole field in quotes and double the quote");
    }
    skip(field.size());
    return std::string(trimmed(field));
  }

  // A doubled quote is an escaped quote (RFC 4180, section 2, rule 7).
  std::string quoted_field() {
    skip(1);
    std::string field(up_to_quote());
    while (rest_.starts_with('"')) {
      skip(1);
      field += '"';
      field += up_to_quote();
    }
    skip_blanks();
    if (!rest_.empty() && !rest_.starts_with(',') && !rest_.starts_with('\n')) {
      fail("text after a quoted field; a comma is needed between fields");
    }
    return field;
  }

  // The text before the next quote, which is consumed too.
  std::string_view up_to_quote() {
    const std::size_t end = rest_.find('"');
    if (end == std::string_view::npos) fail("a quoted field has no closing quote");
    const std::string_view text = rest_.substr(0, end);
    line_ += static_cast<int>(std::count(text.begin(), text.end(), '\n'));
    skip(end + 1);
    return text;
  }

  void end_line() {
    if (rest_.starts_with('\n')) skip(1);
    ++line_;
  }

  void skip_blanks() { skip(std::min(rest_.find_first_not_of(kBlank), rest_.size())); }
  void skip(std::size_t bytes) { rest_.remove_prefix(bytes); }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(source_ + ":" + std::to_string(line_) + ": " + what);
  }

  std::string_view rest_;
  const std::string& source_;
  int line_ = 1;
};

}  // namespace

std::vector<CsvRecord> split_csv(std::string_view text, const std::string& source) {
  return CsvSplitter(text, source).records();
}

}  // namespace raywalk
