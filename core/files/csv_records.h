// The lines of comma-separated text, split into fields (RFC 4180).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

// One record and the line it starts on, counted from 1; a quoted field may span several lines.
struct CsvRecord {
  int line = 0;
  std::vector<std::string> fields;
};

// Splits the text. Unquoted fields are trimmed, quoted ones are not; blank lines and lines that
// start with '#' are skipped; LF and CRLF end a line; a UTF-8 byte order mark is skipped. Throws
// Error with source and line: an unterminated quote, text after a quoted field, a quote inside an
// unquoted field, a NUL byte.
std::vector<CsvRecord> split_csv(std::string_view text, const std::string& source);

}  // namespace raywalk
