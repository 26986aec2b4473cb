// Results of a trade of speed for accuracy.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/judge/trade/trade_setting.h"
#include "core/judge/trade/view_time.h"
#include "core/judge/validation/view_scores.h"

namespace raywalk {

// One setting measured; scores are means over the views.
struct TradeMeasurement {
  // Over views and repetitions; cv::remap of a picture of the truths' size, on all threads.
  ViewTime time{};
  bool disturbed = false;  // other programs disturbed the time: it is not to be relied on
  double peak_mb = 0.0;    // growth of the resident set by one view, 1e6 bytes, room files included
  double mapped_mb = 0.0;  // the part that is pages of the room's files
  ViewScores scores{};
  std::optional<ViewScores> held_out{};  // of held-out stations; none: not measured
  // Equation (11) at the setting's generation and k, in squared 8-bit levels, over the corners that
  // are readable at every k of the sweep; NaN: these are too few (kLeastCommonShare).
  double e_connect = std::numeric_limits<double>::quiet_NaN();
};

// The Pareto fronts (time ratio against each score) that a setting is on.
struct TradeFronts {
  bool psnr_db = false;
  bool ws_psnr_db = false;
  bool ssim = false;
  bool fsim = false;
  bool e_connect = false;
};

struct MeasuredSetting {
  TradeSetting setting{};
  TradeMeasurement measured{};
  TradeFronts pareto{};
};

// A room that settings were rendered from.
struct TradedRoom {
  std::string directory{};
  int stored_width_px = 0;
  std::string depth{};
  std::string compression = "none";  // Room::compression
  double rays_mb = 0.0;              // of the files that hold its panoramas, 1e6 bytes
};

// Agreement of held-out stations and true views on the order of the settings: Spearman's rank
// correlation of each score; NaN where it is undefined.
struct RankAgreement {
  double psnr_db = 0.0;
  double ws_psnr_db = 0.0;
  double ssim = 0.0;
  double fsim = 0.0;
};

// One of the presets.
struct TradedPreset {
  std::string name{};
  std::string reason{};     // explanation for this room
  std::size_t setting = 0;  // index into Trade::settings
};

struct Trade {
  std::vector<TradedRoom> rooms{};  // the room under test first
  std::string truth{};              // source of the truths
  std::string sweep{};              // "quick" or "full"
  std::vector<std::string> views{};
  std::vector<std::string> held_out_views{};
  std::string distances_sha256{};  // distances_sha256() of the first room
  int width_px = 0;                // of the truths
  int threads = 1;                 // all that were used
  std::string cpu{};
  double remap_ms = 0.0;       // median over all settings
  int repetitions = 0;         // of every view
  int connect_viewpoints = 0;  // per side of a cell, for e_connect
  // The central setting of each generation comes before its variations.
  std::vector<MeasuredSetting> settings{};
  std::vector<TradedPreset> presets{};
};

// Over all settings; each must have held-out scores.
RankAgreement rank_agreement(const std::vector<MeasuredSetting>& settings);

// The setting's name, marked where its time is not to be relied on.
std::string marked_name(const MeasuredSetting& setting);

// Number of settings whose times are not to be relied on.
std::size_t disturbed_count(const std::vector<MeasuredSetting>& settings);

// Fills in every setting's fronts: those of the settings whose times are to be relied on, if there
// are any.
void find_fronts(std::vector<MeasuredSetting>* settings);

// Index of the view of middle distance, whose errors the page shows.
constexpr std::size_t pictured_view(std::size_t view_count) { return view_count / 2; }

// Indices of the settings on the front of PSNR, the fastest first.
std::vector<std::size_t> psnr_front(const Trade& trade);

}  // namespace raywalk
