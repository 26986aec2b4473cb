#include "capture/import/session_shots.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cstdint>

#include "capture/session/session_times.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// The camera starts to expose at exposed_utc_us. The times of the single exposures of a bracket are
// not recorded; they lie between then and the end of exposing.
constexpr char kExposedStations[] =
    "SELECT attempt.id, station.name, attempt.number, attempt.outcome = 'captured',"
    " coalesce(attempt.exposed_utc_us, attempt.triggered_utc_us) AS exposed_utc_us,"
    " coalesce(attempt.triggered_utc_us, attempt.exposed_utc_us)"
    " + cast(coalesce(attempt.exposing_ms, 0) * 1000 AS INTEGER) AS end_of_exposing_utc_us "
    "FROM attempt JOIN station ON station.id = attempt.station_id "
    "WHERE attempt.outcome IN ('exposed', 'captured')"
    " AND coalesce(attempt.exposed_utc_us, attempt.triggered_utc_us) IS NOT NULL "
    "ORDER BY 5, attempt.id";

// An attempt interrupted by a crash has no end time; its pictures were taken before the next one
// began.
constexpr char kFailedAttempts[] =
    "SELECT begun_utc_us, coalesce(ended_utc_us, (SELECT min(next.begun_utc_us) FROM attempt AS "
    "next WHERE next.id > attempt.id), begun_utc_us + 60000000)"
    " AS ended_utc_us "
    "FROM attempt WHERE outcome = 'failed' OR outcome IS NULL ORDER BY begun_utc_us";

std::vector<ExposedStation> exposed_stations(SessionReader* reader, int exposures) {
  std::vector<ExposedStation> stations;
  SqliteStatement rows = reader->query(kExposedStations, "an exposed attempt");
  while (rows.step()) {
    ExposedStation station;
    station.attempt = {rows.integer(0, 1, INT64_MAX), rows.name(1), rows.number(2, 1, INT_MAX)};
    station.imported = rows.boolean(3);
    station.from = wall_time_from(rows.utc_us(4));
    station.to = station.from;
    if (exposures > 1) station.to = std::max(station.from, wall_time_from(rows.utc_us(5)));
    stations.push_back(std::move(station));
  }
  return stations;
}

std::vector<FailedAttempt> failed_attempts(SessionReader* reader) {
  std::vector<FailedAttempt> attempts;
  SqliteStatement rows = reader->query(kFailedAttempts, "a failed attempt");
  while (rows.step()) {
    attempts.push_back({wall_time_from(rows.utc_us(0)), wall_time_from(rows.utc_us(1))});
  }
  return attempts;
}

}  // namespace

SessionShots read_session_shots(SessionReader* reader) {
  const SessionFacts facts = reader->facts();
  const std::string directory = reader->directory().string();
  if (facts.camera != CameraKind::kGpio) {
    throw UsageError(fmt::format(
        "{}: the {} camera sent its pictures during the run; there is nothing to import from a "
        "card",
        directory, name_of(facts.camera)));
  }
  if (facts.mode == CaptureMode::kVideo) {
    throw UsageError(fmt::format(
        "{}: this session was captured as video; import its film with --video", directory));
  }
  SessionShots shots;
  shots.exposures = facts.exposures();
  shots.stations = exposed_stations(reader, facts.exposures());
  shots.failed = failed_attempts(reader);
  if (shots.stations.empty()) {
    throw Error(
        fmt::format("{}: no station has been captured yet; run the session first", directory));
  }
  return shots;
}

}  // namespace raywalk::capture
