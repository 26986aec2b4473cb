// The names that a table gives to the files made from its rows.
#pragma once

#include <string>
#include <vector>

#include "core/files/csv.h"

namespace raywalk {

// Column `column` of every row. Throws Error with source and line for a name that cannot be a
// file's before an extension, or not be found in a table without quotes (empty, beginning with a
// dot, with a slash, comma, quote or line break, over 200 bytes), or that is there twice.
std::vector<std::string> file_names_of_rows(const CsvTable& table, const std::string& column);

}  // namespace raywalk
