// Any text either sets values within their bounds, or is rejected with a one-line UsageError.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/files/settings.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  double k_deg = 76.0;
  int width = 4096;
  bool two_sided = false;
  std::string title;
  std::string connection = "hybrid";
  double overlap_deg = 5.0;
  std::vector<double> bracket_ev;
  std::vector<std::string> names;
  std::vector<double> spacings_mm;
  raywalk::SettingsSchema schema;
  schema.number("k_deg", &k_deg, 45.0, 90.0)
      .integer("width", &width, 2, 65536)
      .boolean("two_sided", &two_sided)
      .text("title", &title)
      .choice("connection", &connection, {"hybrid", "lfu"})
      .number("blend.overlap_deg", &overlap_deg, 0.0, 30.0)
      .numbers("bracket_ev", &bracket_ev, -5.0, 5.0, 4)
      .words("names", &names, 4)
      .items(
          "lines",
          [&spacings_mm] {
            raywalk::SettingsSchema item;
            item.number("spacing_mm", &spacings_mm.emplace_back(1.0), 0.5, 100.0);
            return item;
          },
          4);
  try {
    schema.parse(std::string_view(reinterpret_cast<const char*>(data), size), "view.yaml");
  } catch (const raywalk::UsageError& e) {
    raywalk::expect_one_line(e);
  }
  const bool in_bounds = k_deg >= 45.0 && k_deg <= 90.0 && width >= 2 && width <= 65536 &&
                         overlap_deg >= 0.0 && overlap_deg <= 30.0;
  const bool lists_in_bounds =
      bracket_ev.size() <= 4 && names.size() <= 4 && spacings_mm.size() <= 4 &&
      std::ranges::all_of(bracket_ev, [](double ev) { return ev >= -5.0 && ev <= 5.0; }) &&
      std::ranges::all_of(spacings_mm, [](double mm) { return mm >= 0.5 && mm <= 100.0; });
  if (!in_bounds || !lists_in_bounds) std::abort();
  return 0;
}
