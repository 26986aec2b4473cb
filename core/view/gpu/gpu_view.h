// Passes 1 to 3 on a graphics card (core/view/shaders): what DistanceView, Visibility and Edges do,
// to within rounding.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/view/gpu/gpu_context.h"
#include "core/view/gpu/room_textures.h"
#include "core/view/mixed_column.h"

namespace raywalk {

// Where programs find what they read and write. What one makes others read in its place.
enum GpuBinding : GLuint {
  kPlacesBinding,
  kDistancesBinding,
  kOccludedBinding,  // in distances.glsl what is drawn
  kFillsBinding,     // in distances.glsl what is refined
  kQuartersBinding,
  kColumnsBinding,  // in visibility.glsl the sources
  kReadsBinding,    // in visibility.glsl the distances of the other eye
  kPictureBinding
};

// The distance maps of a view: those that distances are gathered from, those that stations to fill
// from are searched in, and all of the view's lines, of which some are wanted.
class ViewMaps {
 public:
  // Of one eye, or of both eyes of a circle.
  void plan(const MixedView& view);
  // Wants maps of a line by the bits from its `first` map on. Returns the place of the first.
  int want(int line, int first, std::uint8_t bits);

  // Puts what is wanted on the card. During a Turn; throws GpuError where it does not fit.
  void require(const MixedView& view, RoomTextures* textures);
  // Tells the program in use of them.
  void bind(const GpuProgram& program) const;
  std::size_t gathered() const { return gathered_; }

 private:
  std::size_t gathered_ = 0, fills_ = 0;
  std::vector<MapStation> maps_;  // gathered_ of them, fills_ of them, and line by line
  std::vector<bool> wanted_;
  std::map<int, int> first_of_line_;
  GpuBuffer places_;
};

// One eye. Used in the order of its functions, from require() on during a Turn.
class GpuView {
 public:
  explicit GpuView(GpuContext* context) : context_(context) {}

  // Without the card: which maps tell what the view's columns see.
  void plan(const MixedView& view, ViewMaps* maps);
  void gather(const MixedView& view, const ViewMaps& maps);
  // `opposite`: the other eye of a circle, or this one.
  void see(const MixedView& view, const ViewMaps& maps, const GpuView& opposite);
  // Tells the program in use of the view and of what was found.
  void bind(const MixedView& view, const ViewMaps& maps, const GpuProgram& program) const;

 private:
  // As visibility.glsl declares it.
  struct Source {
    float met_m = 0.0f;
    std::int32_t image = -1;
    std::uint32_t wanted = 0;
    std::int32_t first_map = 0;
    std::uint32_t before = 0, after = 0;
    float after_part = 0.0f;
    std::int32_t unused = 0;
  };

  void find_smooth(const MixedView& view, std::span<const float> nearest);

  GpuContext* context_;
  std::vector<Source> sources_;  // kMaxSources of each column of the distances
  GpuBuffer distances_, drawn_, refined_, occluded_, fills_, quarters_, sources_there_;
};

}  // namespace raywalk
