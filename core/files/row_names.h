// Output file names taken from a column of a table.
#pragma once

#include <string>
#include <vector>

#include "core/files/csv.h"

namespace raywalk {

// Column `column` of every row, without extension. Throws Error with source and line for a name
// that is not usable as a file name or would need quotes in a table (empty, a leading dot, a slash,
// comma, quote or line break, over 200 bytes), or that occurs twice.
std::vector<std::string> file_names_of_rows(const CsvTable& table, const std::string& column);

}  // namespace raywalk
