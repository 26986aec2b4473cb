// manifest.json of an export, which tells the page everything else.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_options.h"
#include "render/view/path_table.h"
#include "render/web/export_web.h"
#include "render/web/hotspots.h"
#include "render/web/truth_pairs.h"

namespace raywalk::render {

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kWebFormat = "raywalk-web";
inline constexpr int kWebVersion = 1;
inline constexpr double kWebPathFps = 10.0;  // between which the page goes straight

// The name of a station's files, counted through all lines of the export: "0000".
std::string station_name(int index);

// What an export holds besides its lines and cells. Widths are pixels; docs/file-formats.md
// describes the keys.
struct WebContent {
  std::string title{};
  double budget_mb = 0.0;           // 10^6 bytes of GPU memory
  int width = 0;                    // of the panoramas
  int coarse_width = 0;             // of the coarse ones
  int distance_width = 0;           // of the distances
  double inverse_step_per_m = 0.0;  // of inverse distances in files, > 0
  ViewOptions view{};
  PlanPoint start{};
  double vertical_range_m = 0.0;
  std::optional<WebQuality> quality{};
  std::vector<TruthPair> truths{};
  std::vector<Hotspot> hotspots{};
  std::vector<PathView> path{};  // kWebPathFps of them per second
};

// Its keys "lines" and "cells".
nlohmann::ordered_json grid_json(const Grid& grid);

// The whole manifest; `room` has only the stations exported.
nlohmann::ordered_json web_manifest(const Room& room, const WebContent& content);

}  // namespace raywalk::render
