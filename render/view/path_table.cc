#include "render/view/path_table.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/csv.h"
#include "core/view/view_plan.h"

namespace raywalk::render {

namespace fs = std::filesystem;

std::vector<PathView> read_path(const fs::path& file) {
  const CsvTable table =
      CsvTable::read(file, {"name", "x", "z"}, {"y", "yaw", "pitch", "roll", "time"});
  const std::vector<std::string> names = file_names_of_rows(table, "name");
  const auto number = [&](std::size_t row, const char* column) {
    return table.has_column(column) ? table.number(row, column) : 0.0;
  };
  std::vector<PathView> views;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Viewpoint viewpoint(table.number(row, "x"), table.number(row, "z"));
    if (table.has_column("y")) viewpoint.height_m = table.number(row, "y");
    views.push_back({.name = names[row],
                     .viewpoint = viewpoint,
                     .yaw_deg = number(row, "yaw"),
                     .pitch_deg = number(row, "pitch"),
                     .roll_deg = number(row, "roll"),
                     .time_s = number(row, "time")});
  }
  if (views.empty()) throw Error(file.string() + ": no views; give at least one line name,x,z");
  return views;
}

void require_inside(const Room& room, const ConnectionRule& rule, const fs::path& path,
                    std::span<const PathView> views, double eyes_apart_m) {
  for (const PathView& view : views) {
    try {
      const ViewPlan plan(room.grid(), view.viewpoint, rule, 0.5 * eyes_apart_m);
    } catch (const Error& e) {
      const std::string place = view.place.empty() ? "" : " (" + view.place + ")";
      throw Error(fmt::format("{}: view '{}'{}: {}", path.string(), view.name, place, e.what()));
    }
  }
}

ViewFrame turned_as(const PathView& view, ViewFrame frame) {
  frame.yaw_deg = view.yaw_deg;
  frame.pitch_deg = view.pitch_deg;
  frame.roll_deg = view.roll_deg;
  return frame;
}

}  // namespace raywalk::render
