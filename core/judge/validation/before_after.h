// Compares two rooms of one place, packed before and after a correction: the same views against the
// same truth, and the connection errors at the same angles.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/judge/validation/validate.h"
#include "core/report/json_page.h"

namespace raywalk {

// Mean scores of a generation's views.
struct ScoresBeforeAfter {
  Generation generation = Generation::kInitial;
  ViewScores before{};
  ViewScores after{};
};

// E_connect in squared 8-bit levels; NaN where it was not measured.
struct ConnectionBeforeAfter {
  Generation generation = Generation::kInitial;
  double k_deg = 0.0;
  double before = 0.0;
  double after = 0.0;
};

struct BeforeAfter {
  std::string before{};  // the rooms
  std::string after{};
  // Distances in use there: Room::distances_origin().
  std::string distances_before{};
  std::string distances_after{};
  std::vector<ScoresBeforeAfter> scores{};          // empty without true views
  std::vector<ConnectionBeforeAfter> connection{};  // empty where a room has no cell
};

// What both rooms were measured for; a generation that one of them cannot show is left out.
BeforeAfter compare_rooms(const Validation& before, const Validation& after);

// The key "before_after" of metrics.json:
//   {"before", "after": rooms, "distances_before", "distances_after",
//    "means": [{"generation", "before", "after", "gain": {"psnr_db", "ws_psnr_db", "ssim",
//    "fsim"}}], "connection_error": [{"generation", "k_deg", "before", "after", "ratio": after /
//    before}]}
// Gains are after minus before. What was not measured is null.
nlohmann::ordered_json before_after_json(const BeforeAfter& rooms);

// A section of the report. `rooms`: the part that before_after_json made.
void add_before_after(JsonPage rooms);

// Lines for the user, each ending with a newline: one per generation with its scores, and one with
// E_connect at the largest k.
std::string before_after_text(const BeforeAfter& rooms);

}  // namespace raywalk
