#include "capture/session/session_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "capture/plan/line_selection.h"
#include "core/base/error.h"
#include "core/session/session_contents.h"
#include "core/session/session_file.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

WholePlan whole_of(const CapturePlan& plan, const CameraConfig& camera) {
  WholePlan whole{.lines = {}, .sha256 = grid_sha256(plan, camera)};
  for (const CaptureLine& line : plan.lines) whole.lines.push_back(line.id);
  return whole;
}

std::optional<PanoramaSize> frame_size_of(SessionReader* session) {
  SqliteStatement row = session->query("SELECT width_px, height_px FROM frame LIMIT 1", "a frame");
  if (!row.step()) return std::nullopt;
  constexpr int kLargest = 1 << 20;
  return PanoramaSize{row.number(0, 1, kLargest), row.number(1, 1, kLargest)};
}

std::vector<CapturedLine> lines_of(SessionReader* session, const SessionContents& contents) {
  std::map<std::string, std::int64_t> ended_us;
  SqliteStatement row = session->query(
      "SELECT line.name, max(last_us) FROM ("
      " SELECT station.line_id AS line_id, attempt.ended_utc_us AS last_us FROM attempt"
      "  JOIN station ON station.id = station_id WHERE outcome IN ('captured', 'exposed')"
      " UNION ALL SELECT line_id, at_utc_us FROM journal)"
      " JOIN line ON line.id = line_id GROUP BY line.id",
      "a captured line");
  while (row.step()) ended_us[row.name(0)] = row.utc_us(1);
  std::vector<CapturedLine> lines;
  for (std::size_t i = 0; i < contents.lines.size(); ++i) {
    const auto ended = ended_us.find(contents.lines[i].id);
    if (ended == ended_us.end()) continue;
    CapturedLine line{.id = ended->first, .ended_utc_us = ended->second};
    for (const SessionStation& station : contents.stations) {
      if (station.line != static_cast<int>(i)) continue;
      ++line.planned;
      line.captured += station.shot ? 1 : 0;
    }
    lines.push_back(line);
  }
  return lines;
}

// What differs between two sessions, as text; empty if they may be merged.
std::string difference_of(const SessionPart& a, const SessionPart& b) {
  const auto differ = [](std::string_view what, std::string_view there, std::string_view here) {
    return there == here ? std::string() : fmt::format("{} is {} and {}", what, there, here);
  };
  const auto size_text = [](const std::optional<PanoramaSize>& size) {
    return size ? fmt::format("{} x {}", size->width, size->height) : std::string();
  };
  std::string text = differ("the camera", name_of(a.facts.camera), name_of(b.facts.camera));
  if (text.empty()) text = differ("the mode", name_of(a.facts.mode), name_of(b.facts.mode));
  if (text.empty()) text = differ("frames", name_of(a.facts.frames), name_of(b.facts.frames));
  if (text.empty() && a.frame_size && b.frame_size) {
    text = differ("the size of pictures", size_text(a.frame_size), size_text(b.frame_size));
  }
  if (text.empty() && a.whole.sha256 != b.whole.sha256) {
    return "they are of different plans: other lines, stations or exposures";
  }
  return text;
}

}  // namespace

SessionPart read_session_part(SessionReader* session) {
  SessionPart part;
  part.directory = fs::absolute(session->directory()).lexically_normal();
  if (!part.directory.has_filename()) part.directory = part.directory.parent_path();
  part.name = part.directory.filename().string();
  part.facts = session->facts();
  part.contents = session->contents();
  require_no_faults(frame_faults(part.contents), session->directory());
  part.plan = plan_of(part.contents);
  part.plan.part_of = session->part_of();
  part.camera.kind = part.facts.camera;
  part.camera.frames = part.facts.frames;
  part.camera.exposure.bracket_ev = part.facts.bracket_ev;
  part.whole = part.plan.part_of ? *part.plan.part_of : whole_of(part.plan, part.camera);
  part.frame_size = frame_size_of(session);
  part.lines = lines_of(session, part.contents);
  return part;
}

void require_same_capture(const std::vector<SessionPart>& parts) {
  const SessionPart& first = parts.front();
  for (const SessionPart& part : parts) {
    const std::string difference = difference_of(first, part);
    if (difference.empty()) continue;
    throw Error(fmt::format("{} and {} cannot be merged: {}", first.directory.string(),
                            part.directory.string(), difference));
  }
}

}  // namespace raywalk::capture
