#include "core/session/stored_plan.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/files/json.h"
#include "core/session/session_file.h"

namespace raywalk {
namespace {

// The plan is stored rounded to 1 nm.
constexpr double kRounding_m = 1e-9;
constexpr double kRounding_mm = 1e-6;

class PlanComparison {
 public:
  explicit PlanComparison(const SessionContents& contents) : contents_(contents) {}

  void require_same(const CheckedJson& plan) {
    const std::vector<CheckedJson> lines = plan.at("lines").items();
    require_count(lines.size(), contents_.lines.size(), "lines");
    require(plan.at("frames").text() == contents_.frame_kind, "the kind of frames");
    require(static_cast<int>(plan.at("bracket_ev").items().size()) == contents_.exposures,
            "the number of exposures");
    for (std::size_t i = 0; i < lines.size(); ++i) require_line(lines[i], static_cast<int>(i));
    require_count(next_station_, contents_.stations.size(), "stations");
  }

 private:
  void require_line(const CheckedJson& planned, int index) {
    const SessionLine& line = contents_.lines[static_cast<std::size_t>(index)];
    const std::string name = "line " + line.id;
    require(planned.at("id").text() == line.id, name);
    require(planned.at("axis").text() == name_of(line.axis), "the axis of " + name);
    require(is_close(planned.at("across_m").number(), line.across_m, kRounding_m),
            "across_m of " + name);
    require(planned.at("validation").boolean() == line.validation, "validation of " + name);
    for (const CheckedJson& station : planned.at("stations").items()) {
      require_station(station, index);
    }
  }

  void require_station(const CheckedJson& planned, int line) {
    const std::string name = planned.at("name").text();
    const bool is_there = next_station_ < contents_.stations.size() &&
                          contents_.stations[next_station_].name == name &&
                          contents_.stations[next_station_].line == line;
    require(is_there, "station " + name);
    const SessionStation& station = contents_.stations[next_station_++];
    require(is_close(planned.at("x_m").number(), station.planned_m.x_m, kRounding_m) &&
                is_close(planned.at("z_m").number(), station.planned_m.z_m, kRounding_m) &&
                is_close(planned.at("rail_mm").number(), station.planned_mm, kRounding_mm),
            "the place of station " + name);
  }

  static bool is_close(double a, double b, double tolerance) {
    return std::abs(a - b) <= tolerance * (1.0 + 1e-3);
  }

  void require_count(std::size_t planned, std::size_t there, const std::string& what) const {
    if (planned == there) return;
    throw_damaged_session(
        contents_.directory,
        fmt::format("its tables hold {} {}, its plan (plan_json) {}", there, what, planned));
  }

  void require(bool same, const std::string& what) const {
    if (same) return;
    throw_damaged_session(
        contents_.directory,
        fmt::format("{} differs between its tables and its plan (plan_json)", what));
  }

  const SessionContents& contents_;
  std::size_t next_station_ = 0;
};

}  // namespace

void require_stored_plan(const SessionContents& contents, const std::string& plan_json) {
  const std::string source =
      session_database_path(contents.directory).string() + ": damaged: plan_json";
  PlanComparison(contents).require_same(
      CheckedJson::parse(plan_json, source, "restore this file from a copy"));
}

}  // namespace raywalk
