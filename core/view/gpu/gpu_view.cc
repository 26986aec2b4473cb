#include "core/view/gpu/gpu_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>

#include "core/base/parallel.h"
#include "core/view/gpu/shader_text.h"
#include "core/view/mask_check.h"

namespace raywalk {
namespace {

// As maps.glsl declares it.
struct MapPlace {
  std::array<float, 4> from_centre{};
  std::int32_t layer = -1, width = 0, rows = 0;
  std::int32_t masks = -1;
  std::int32_t moved_width = 0, moved_rows = 0;
  std::array<std::int32_t, 2> unused{};
};
static_assert(sizeof(MapPlace) == 48);

ImageKey map_key(const MapStation& map) { return {map.line, map.map}; }

}  // namespace

void ViewMaps::plan(const MixedView& view) {
  const auto gathered = view.distances.maps();
  maps_.assign(gathered.begin(), gathered.end());
  gathered_ = maps_.size();
  fills_ = view.fill.maps().size();
  maps_.insert(maps_.end(), view.fill.maps().begin(), view.fill.maps().end());
  wanted_.assign(maps_.size(), true);
  first_of_line_.clear();
  for (const int line : view.visibility.lines()) {
    first_of_line_[line] = static_cast<int>(maps_.size());
    int map = 0;
    for (const int station : view.room.distances(line).stations()) {
      const auto& stations = view.room.grid().lines[static_cast<std::size_t>(line)].stations;
      maps_.push_back(
          {line, map++, station, stations[static_cast<std::size_t>(station)].position_m});
    }
  }
  wanted_.resize(maps_.size(), false);
}

int ViewMaps::want(int line, int first, std::uint8_t bits) {
  const int place = first_of_line_.at(line) + first;
  for (unsigned left = bits; left != 0; left &= left - 1) {
    const int of_bit = place + std::countr_zero(left);
    wanted_[static_cast<std::size_t>(of_bit)] = true;
  }
  return place;
}

void ViewMaps::require(const MixedView& view, RoomTextures* textures) {
  std::set<ImageKey> maps, masks;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (wanted_[i]) maps.insert(map_key(maps_[i]));
  }
  for (const MapStation& map : view.fill.maps()) masks.insert({map.line, map.station});
  textures->require_maps(std::vector(maps.begin(), maps.end()));
  textures->require_masks(std::vector(masks.begin(), masks.end()));
  std::vector<MapPlace> places;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const MapStation& map = maps_[i];
    const Eigen::Vector3f from = (map.position_m - view.distances.eye().centre_m).cast<float>();
    const PanoramaSize size = view.room.distances(map.line).size();
    MapPlace& place = places.emplace_back();
    place.from_centre = {from.x(), from.y(), from.z(), 0.0f};
    place.layer = textures->map_layer(map_key(map));
    place.width = size.width;
    place.rows = size.height;
    if (i < gathered_ || i >= gathered_ + fills_) continue;
    if (has_masks(view.room, map.line, map.station)) {
      place.masks = textures->mask_layer({map.line, map.station});
    }
    const LeftOutPixels& moved = view.room.distances(map.line).left_out();
    if (!moved.any(map.station)) continue;
    place.moved_width = moved.size().width;
    place.moved_rows = moved.size().height;
  }
  places_.write(std::span<const MapPlace>(places));
}

void ViewMaps::bind(const GpuProgram& program) const {
  places_.bind(kPlacesBinding);
  program.set("gathered", static_cast<int>(gathered_));
  program.set("fill_maps", static_cast<int>(gathered_), static_cast<int>(fills_));
}

void GpuView::plan(const MixedView& view, ViewMaps* maps) {
  const Visibility::Columns columns = view.visibility.columns();
  const int width = view.distances.size().width;
  sources_.assign(kMaxSources * static_cast<std::size_t>(width), {});
  const auto for_sources = [&](int theta, const auto& use) {
    const ColumnSources& of_column = view.visibility.sources(theta);
    for (std::size_t i = 0; i < of_column.count; ++i) {
      use(i, of_column.source[i].at, &sources_[kMaxSources * static_cast<std::size_t>(theta) + i]);
    }
  };
  parallel_for(0, columns.count, 16, [&](int begin, int end) {
    for (int column = begin; column < end; ++column) {
      const int theta = (columns.first + column) % width;
      for_sources(theta, [&](std::size_t i, const RaySource& at, Source* source) {
        const Visibility::SourceMaps of = view.visibility.maps_of(theta, i);
        *source = {.met_m = static_cast<float>(at.d_p_m),
                   .image = static_cast<std::int32_t>(of.image),
                   .wanted = of.wanted,
                   .first_map = of.first_map,
                   .before = of.by.before,
                   .after = of.by.after,
                   .after_part = of.by.after_part};
      });
    }
  });
  for (int column = 0; column < columns.count; ++column) {
    const int theta = (columns.first + column) % width;
    for_sources(theta, [&](std::size_t, const RaySource& at, Source* source) {
      source->first_map =
          maps->want(at.line, source->first_map, static_cast<std::uint8_t>(source->wanted));
    });
  }
}

void GpuView::bind(const MixedView& view, const ViewMaps& maps, const GpuProgram& program) const {
  maps.bind(program);
  program.set("maps", static_cast<int>(RoomTextures::kMaps));
  program.set("masks", static_cast<int>(RoomTextures::kMasks));
  program.set("distance_size", view.distances.size());
  program.set("tolerance", view.distances.surface_tolerance());
  program.set("eye_radius_m", static_cast<float>(view.distances.eye().radius_m));
  program.set("has_trust", view.distances.unreliable());
  program.set("captured", view.room.panorama());
  distances_.bind(kDistancesBinding);
  occluded_.bind(kOccludedBinding);
  fills_.bind(kFillsBinding);
  quarters_.bind(kQuartersBinding);
}

void GpuView::gather(const MixedView& view, const ViewMaps& maps) {
  const PanoramaSize size = view.distances.size();
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  for (GpuBuffer* buffer : {&drawn_, &refined_, &occluded_, &fills_}) buffer->reserve(4 * pixels);
  distances_.reserve((view.distances.unreliable() ? 12 : 4) * pixels);
  quarters_.reserve(16 * pixels);
  const auto use = [&](const char* pass) -> const GpuProgram& {
    const GpuProgram& program = context_->program(
        "distances", fmt::format("#define {}\n", pass),
        {kGeometryShader, kMapsShader, kLookupShader, kGatheringShader, kDistancesShader});
    program.use();
    bind(view, maps, program);
    drawn_.bind(kOccludedBinding);
    refined_.bind(kFillsBinding);
    return program;
  };
  std::vector<float> nearest;  // what the nearest map shows
  const GpuProgram& draw = use("DRAW");
  for (std::size_t i = 0; i < maps.gathered(); ++i) {
    const PanoramaSize map = view.room.distances(view.distances.maps()[i].line).size();
    draw.set("drawn_map", static_cast<int>(i));
    run((map.height + 1) / 2, (map.width + 1) / 2);
    if (i > 0 || !view.distances.unreliable()) continue;
    drawn_.read(4 * pixels, [&](const std::byte* words) {
      nearest.resize(pixels, -1.0f);
      for (std::size_t k = 0; k < pixels; ++k) {
        std::uint32_t word = 0;
        std::memcpy(&word, words + 4 * k, 4);
        if (word != 0) nearest[k] = std::bit_cast<float>(word - 1);
      }
    });
  }
  use("REFINE");
  run(size.height, size.width);
  if (view.distances.unreliable()) find_smooth(view, nearest);
  use("FILL");
  run(size.height, size.width);
  check_gpu("distances");
}

void GpuView::find_smooth(const MixedView& view, std::span<const float> nearest) {
  std::vector<float> seen(nearest.size());
  const std::size_t bytes = 4 * seen.size();
  refined_.read(bytes, [&](const std::byte* from) { std::memcpy(seen.data(), from, bytes); });
  const SmoothDistances& smooth = view.distances.find_smooth(std::move(seen), nearest);
  std::size_t at = bytes;
  for (const cv::Mat1f* part : {&smooth.trust(), &smooth.inverse()}) {
    const cv::Mat1f whole = part->clone();
    distances_.write(at, std::as_bytes(std::span(whole.ptr<float>(), whole.total())));
    at += bytes;
  }
}

void GpuView::see(const MixedView& view, const ViewMaps& maps, const GpuView& opposite) {
  const PanoramaSize size = view.distances.size();
  const Visibility::Columns columns = view.visibility.columns();
  sources_there_.write(std::span<const Source>(sources_));
  const GpuProgram& visibility = context_->program(
      "visibility", fmt::format("#define ROWS {}\n", size.height),
      {kGeometryShader, kMapsShader, kLookupShader, kFillShader, kVisibilityShader});
  visibility.use();
  bind(view, maps, visibility);
  sources_there_.bind(kColumnsBinding);
  opposite.distances_.bind(kReadsBinding);
  visibility.set("first_column", columns.first);
  visibility.set("above_lines_m", static_cast<float>(view.visibility.above_lines_m()));
  visibility.set("fills_empty", columns.fills_empty);
  run_groups(columns.count, 1);
  const GpuProgram& edges = context_->program(
      "edges", "", {kGeometryShader, kMapsShader, kLookupShader, kQuartersShader, kEdgesShader});
  edges.use();
  bind(view, maps, edges);
  edges.set("edge_columns", columns.first, columns.count);
  run(size.height, columns.count);
  check_gpu("what stations see");
}

}  // namespace raywalk
