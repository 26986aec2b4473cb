#include "core/view/mixed_column.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"
#include "core/view/mask_check.h"

namespace raywalk {
namespace {

// The two stations around the point where a line is met, by nearness.
void add_cut(const MixedView& view, std::size_t source, MixedColumn* column) {
  const ColumnSource& of = column->sources.source[source];
  for (const int next : {0, 1}) {
    const auto part = static_cast<float>(next == 0 ? 1.0 - of.at.fraction : of.at.fraction);
    if (part <= 0.0f) continue;
    const bool masked = view.room.volume(of.at.line).masked();
    column->reads.push_back({.source = source,
                             .line = of.at.line,
                             .station = of.at.station + next,
                             .share = {.reliable = of.share * part},
                             .has_masks = masked});
    column->any_masks |= masked;
  }
}

void add_reads(const MixedView& view, std::size_t source, MixedColumn* column) {
  const ColumnSource& of = column->sources.source[source];
  const int line = of.at.line;
  const StationMix mix = station_mix(view.options);
  // Where distances are unreliable a single station would show things out of place: the two
  // neighbours are mixed by nearness.
  const StationMix two{.stations = 1, .fade = 1.0};  // fading all the way between them
  const StationMix unreliable = mix.stations > 2 ? mix : two;
  const StationWindow window =
      stations_mixed(of.at, view.room.volume(line).stations(),
                     column->trust == nullptr || mix.stations > 1 ? mix : two);
  const std::size_t first = column->reads.size();
  StationShare sum{0.0f, 0.0f};
  for (int station = window.first; station <= window.last; ++station) {
    const double from_met = station - of.at.station - of.at.fraction;
    const StationShare share{station_share(from_met, mix), station_share(from_met, unreliable)};
    constexpr float kNone = 1e-3f;
    if (share.reliable < kNone && (column->trust == nullptr || share.unreliable < kNone)) continue;
    sum.reliable += share.reliable;
    sum.unreliable += share.unreliable;
    column->reads.push_back(
        {.source = source,
         .line = line,
         .station = station,
         .share = share,
         .by = view.visibility.occluders(column->nearest, line, of.behind(), station),
         .has_masks = has_masks(view.room, line, station)});
    column->any_masks |= column->reads.back().has_masks;
  }
  for (ColumnRead& read : std::span(column->reads).subspan(first)) {
    read.share.reliable *= of.share / sum.reliable;
    read.share.unreliable *= of.share / std::max(sum.unreliable, 1e-6f);
  }
}

}  // namespace

void prepare_column(const MixedView& view, int u, MixedColumn* column) {
  MixedColumn& c = *column;
  const int captured = view.room.panorama().width;
  c.u = u;
  c.theta_rad = theta_of_column(u, view.output.width);
  c.captured = static_cast<float>((u + 0.5) * captured / view.output.width - 0.5 + captured);
  c.sources = view.sources(c.theta_rad);
  c.reads.clear();
  c.any_masks = false;
  if (view.is_initial()) {
    for (std::size_t i = 0; i < c.sources.count; ++i) add_cut(view, i, column);
    return;
  }
  const int width = view.distances.size().width;
  c.eye_m = view.distances.eye().position_m(c.theta_rad);
  const double at = (u + 0.5) * width / view.output.width - 0.5;
  c.nearest = wrapped_column(static_cast<int>(std::floor(at + 0.5)), width);
  c.right = static_cast<float>(at - std::floor(at + 0.5));
  c.other = wrapped_column(c.nearest + (c.right < 0.0f ? -1 : 1), width);
  c.trust = view.distances.trust(c.nearest);
  for (std::size_t i = 0; i < c.sources.count; ++i) add_reads(view, i, column);
}

}  // namespace raywalk
