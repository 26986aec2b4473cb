#include "core/session/checked_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/session/session_file.h"

namespace raywalk {
namespace {

constexpr std::int64_t kLatest_us = 7258118400000000;  // 2200-01-01; a WallTime holds until 2262

std::string found_value(const SqliteStatement& statement, int column) {
  switch (statement.type(column)) {
    case SQLITE_NULL:
      return "NULL";
    case SQLITE_BLOB:
      return "a blob";
    case SQLITE_FLOAT:
      return fmt::format("{:.6g}", statement.real(column));
    default:
      return excerpt(statement.text(column));
  }
}

}  // namespace

CheckedRow::CheckedRow(SqliteConnection* database, const std::string& sql,
                       std::filesystem::path directory, std::string row)
    : statement_(database, sql), directory_(std::move(directory)), row_(std::move(row)) {}

void CheckedRow::fail(int column, const std::string& what) const {
  throw_damaged_session(
      directory_, fmt::format("{} of {} is {}; it must be {}", statement_.column_name(column), row_,
                              found_value(statement_, column), what));
}

std::int64_t CheckedRow::integer(int column, std::int64_t min, std::int64_t max) const {
  const std::int64_t value = statement_.integer(column);
  if (statement_.type(column) != SQLITE_INTEGER || value < min || value > max) {
    fail(column, fmt::format("a whole number from {} to {}", min, max));
  }
  return value;
}

int CheckedRow::number(int column, int min, int max) const {
  return static_cast<int>(integer(column, min, max));
}

double CheckedRow::real(int column, double min, double max) const {
  const double value = statement_.real(column);
  // In this form NaN fails as well.
  if (statement_.type(column) != SQLITE_FLOAT || !(value >= min && value <= max)) {
    fail(column, fmt::format("a number from {:.10g} to {:.10g}", min, max));
  }
  return value;
}

std::string CheckedRow::document(int column) const {
  if (statement_.type(column) != SQLITE_TEXT) fail(column, "text");
  return statement_.text(column);
}

std::string CheckedRow::text(int column) const {
  std::string text = document(column);
  const bool plain = std::none_of(text.begin(), text.end(),
                                  [](unsigned char c) { return c < ' ' || c == '\x7f'; });
  if (!plain) fail(column, "text without control characters");
  return text;
}

std::string CheckedRow::name(int column) const {
  std::string name = text(column);
  if (name.empty()) fail(column, "a name");
  return name;
}

std::int64_t CheckedRow::utc_us(int column) const { return integer(column, 0, kLatest_us); }

std::optional<std::int64_t> CheckedRow::optional_utc_us(int column) const {
  return is_null(column) ? std::nullopt : std::optional(utc_us(column));
}

}  // namespace raywalk
