// Any text is either parsed, with all cells readable, or rejected with a one-line Error.
#include <cstdint>
#include <string_view>

#include "core/base/error.h"
#include "core/files/csv.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const auto table = raywalk::CsvTable::parse(text, "poses.csv", {"file", "x", "y", "z"},
                                                {"yaw", "pitch", "roll"});
    for (std::size_t row = 0; row < table.rows(); ++row) {
      table.text(row, "file");
      table.number(row, "x");
    }
  } catch (const raywalk::Error& e) {
    raywalk::expect_one_line(e);
  }
  return 0;
}
