// The tables of session.db. docs/session.md explains every column; session_readers_test.cc of
// capture checks that the two agree.
#pragma once

namespace raywalk {

// The format that this program writes, and the newest one it reads: PRAGMA user_version.
inline constexpr int kSessionFormatVersion = 1;

// "RWLK", PRAGMA application_id: marks the SQLite file as a session.
inline constexpr int kSessionApplicationId = 0x52574c4b;

// Times are microseconds since 1970-01-01 00:00 UTC, world positions metres (frame of
// core/geometry/sphere.h), rail positions millimetres and durations milliseconds.
inline constexpr char kSessionSchema[] = R"sql(
CREATE TABLE session (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  created_utc_us INTEGER NOT NULL,
  mode TEXT NOT NULL,
  camera TEXT NOT NULL,
  frames TEXT NOT NULL,
  bracket_ev TEXT NOT NULL CHECK (json_array_length(bracket_ev) BETWEEN 1 AND 1000),
  locked_exposure TEXT NOT NULL DEFAULT '',
  part_of TEXT,
  config_text TEXT NOT NULL
) STRICT;

CREATE TABLE line (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  axis TEXT NOT NULL CHECK (axis IN ('x', 'z')),
  across_m REAL NOT NULL,
  validation INTEGER NOT NULL CHECK (validation IN (0, 1))
) STRICT;

CREATE TABLE station (
  id INTEGER PRIMARY KEY,
  line_id INTEGER NOT NULL REFERENCES line (id),
  number INTEGER NOT NULL,
  name TEXT NOT NULL UNIQUE,
  x_m REAL NOT NULL,
  z_m REAL NOT NULL,
  planned_mm REAL NOT NULL,
  UNIQUE (line_id, number)
) STRICT;

CREATE TABLE attempt (
  id INTEGER PRIMARY KEY,
  station_id INTEGER NOT NULL REFERENCES station (id),
  number INTEGER NOT NULL,
  outcome TEXT CHECK (outcome IN ('captured', 'exposed', 'failed')),
  begun_utc_us INTEGER NOT NULL,
  ended_utc_us INTEGER,
  commanded_mm REAL NOT NULL,
  measured_mm REAL,
  moving_ms REAL,
  settling_ms REAL,
  triggered_utc_us INTEGER,
  exposed_utc_us INTEGER,
  exposing_ms REAL,
  transfer_ms REAL,
  own_ms REAL,
  fault TEXT,
  message TEXT,
  UNIQUE (station_id, number)
) STRICT;
CREATE UNIQUE INDEX captured_once ON attempt (station_id) WHERE outcome IN ('captured', 'exposed');

CREATE TABLE frame (
  id INTEGER PRIMARY KEY,
  attempt_id INTEGER NOT NULL REFERENCES attempt (id),
  exposure INTEGER NOT NULL,
  lens TEXT NOT NULL CHECK (lens IN ('both', 'front', 'back')),
  file TEXT NOT NULL UNIQUE,
  bytes INTEGER NOT NULL,
  sha256 TEXT NOT NULL,
  width_px INTEGER NOT NULL,
  height_px INTEGER NOT NULL,
  camera_name TEXT NOT NULL,
  settings TEXT NOT NULL,
  UNIQUE (attempt_id, exposure, lens)
) STRICT;

CREATE TABLE event (
  id INTEGER PRIMARY KEY,
  at_utc_us INTEGER NOT NULL,
  kind TEXT NOT NULL,
  text TEXT NOT NULL
) STRICT;

CREATE TABLE journal (
  id INTEGER PRIMARY KEY,
  line_id INTEGER NOT NULL REFERENCES line (id),
  at_utc_us INTEGER NOT NULL,
  position_mm REAL NOT NULL
) STRICT;
CREATE INDEX journal_of_line ON journal (line_id);

CREATE VIEW captured_frame AS
SELECT frame.file, line.name AS line, line.validation, station.name AS station, station.number,
       frame.exposure, frame.lens,
       station.x_m + (line.axis = 'x') * (attempt.measured_mm - station.planned_mm) / 1000.0 AS x_m,
       station.z_m + (line.axis = 'z') * (attempt.measured_mm - station.planned_mm) / 1000.0 AS z_m,
       attempt.measured_mm, frame.bytes, frame.sha256
FROM frame
JOIN attempt ON attempt.id = frame.attempt_id AND attempt.outcome = 'captured'
JOIN station ON station.id = attempt.station_id
JOIN line ON line.id = station.line_id;
)sql";

}  // namespace raywalk
