#include "core/judge/validation/before_after.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/escaped.h"
#include "core/report/markup.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

std::optional<std::size_t> mode_of(const Validation& validation, Generation generation) {
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.modes[mode].options.generation == generation) return mode;
  }
  return std::nullopt;
}

std::vector<ScoresBeforeAfter> compared_scores(const Validation& before, const Validation& after) {
  std::vector<ScoresBeforeAfter> scores;
  if (before.views.empty() || after.views.empty()) return scores;
  for (std::size_t mode = 0; mode < after.modes.size(); ++mode) {
    const Generation generation = after.modes[mode].options.generation;
    const auto same = mode_of(before, generation);
    if (!same) continue;
    scores.push_back({generation, mean_scores(before, *same), mean_scores(after, mode)});
  }
  return scores;
}

std::vector<ConnectionBeforeAfter> compared_connection(const Validation& before,
                                                       const Validation& after) {
  std::vector<ConnectionBeforeAfter> rows;
  for (const ConnectError& measured : after.connection_error) {
    const auto same =
        std::ranges::find(before.connection_error, measured.generation, &ConnectError::generation);
    if (same == before.connection_error.end()) continue;
    for (const ConnectErrorRow& row : measured.rows) {
      const auto at = std::ranges::find(same->rows, row.k_deg, &ConnectErrorRow::k_deg);
      if (at == same->rows.end()) continue;
      rows.push_back({measured.generation, row.k_deg, at->e_connect, row.e_connect});
    }
  }
  return rows;
}

ordered_json json_of(const ScoresBeforeAfter& scores) {
  ordered_json before, after, gain;
  for (const NamedScore& score : kNamedScores) {
    before[score.key] = scores.before.*score.member;
    after[score.key] = scores.after.*score.member;
    gain[score.key] = scores.after.*score.member - scores.before.*score.member;
  }
  return {{"generation", generation_name(scores.generation)},
          {"before", before},
          {"after", after},
          {"gain", gain}};
}

// NaN and infinity become null when the text is written.
ordered_json json_of(const ConnectionBeforeAfter& row) {
  return {{"generation", generation_name(row.generation)},
          {"k_deg", row.k_deg},
          {"before", row.before},
          {"after", row.after},
          {"ratio", row.after / row.before}};
}

}  // namespace

BeforeAfter compare_rooms(const Validation& before, const Validation& after) {
  return {.before = before.volume,
          .after = after.volume,
          .distances_before = before.distances,
          .distances_after = after.distances,
          .scores = compared_scores(before, after),
          .connection = compared_connection(before, after)};
}

ordered_json before_after_json(const BeforeAfter& rooms) {
  ordered_json means = ordered_json::array(), connection = ordered_json::array();
  for (const ScoresBeforeAfter& scores : rooms.scores) means.push_back(json_of(scores));
  for (const ConnectionBeforeAfter& row : rooms.connection) connection.push_back(json_of(row));
  return {{"before", rooms.before},
          {"after", rooms.after},
          {"distances_before", rooms.distances_before},
          {"distances_after", rooms.distances_after},
          {"means", means},
          {"connection_error", connection}};
}

void add_before_after(JsonPage rooms) {
  JsonTable scores{.caption = "Mean over all views; gains are after minus before",
                   .header = {"generation", "score", "before", "after", "gain"}};
  for (const NamedScore& score : kNamedScores) {
    const auto cell = [&](const std::string& text) {
      return fmt::format(fmt::runtime(text), score.key, score.decimals);
    };
    scores.rows.push_back({"means",
                           {{"{generation}"},
                            {score.heading},
                            {cell("{{before.{}:.{}f}}"), cell("before.{0} > after.{0}")},
                            {cell("{{after.{}:.{}f}}"), cell("after.{0} > before.{0}")},
                            {cell("{{gain.{}:+.{}f}}")}}});
  }
  rooms.section("Before and after")
      .paragraph(
          "Before: {before} (distances: {distances_before}). After: {after} (distances: "
          "{distances_after}). Both are rendered at the same viewpoints with the same settings; "
          "the better of both is emphasised.")
      .table(scores)
      .table("connection_error",
             {{"generation", "{generation}"},
              {"k / deg", "{k_deg:g}"},
              {"before", "{before:.1f}", "before < after"},
              {"after", "{after:.1f}", "after < before"},
              {"after / before", "{ratio:.3f}"}},
             "E_connect, equation (11) of the paper, in squared 8-bit levels, over the corners "
             "that each room can read; smaller is better");
}

std::string before_after_text(const BeforeAfter& rooms) {
  std::string text = "gain over " + escaped(rooms.before) + ":\n";
  for (const ScoresBeforeAfter& scores : rooms.scores) {
    text += fmt::format(
        "{:<10} PSNR {:+.2f} dB  WS-PSNR {:+.2f} dB  SSIM {:+.4f}  FSIM {:+.4f}\n",
        generation_name(scores.generation), scores.after.psnr_db - scores.before.psnr_db,
        scores.after.ws_psnr_db - scores.before.ws_psnr_db, scores.after.ssim - scores.before.ssim,
        scores.after.fsim - scores.before.fsim);
  }
  for (std::size_t i = 0; i < rooms.connection.size(); ++i) {
    const ConnectionBeforeAfter& row = rooms.connection[i];
    const bool last =
        i + 1 == rooms.connection.size() || rooms.connection[i + 1].generation != row.generation;
    if (!last) continue;
    text += fmt::format("{:<10} E_connect at k = {:g}: {} before, {} after\n",
                        generation_name(row.generation), row.k_deg, number_or_dash(row.before, 1),
                        number_or_dash(row.after, 1));
  }
  return text;
}

}  // namespace raywalk
