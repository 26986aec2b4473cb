// The panoramas of stations on a graphics card, as many as fit.
#pragma once

#include <GLES3/gl31.h>

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// A station by its line and its index there.
using StationKey = std::pair<int, int>;

// Layers of one array texture, RGBA, [theta][phi]: the colours, and in the fourth channel 255 where
// they may be used, 128 where something moved, 0 where they are masked. All is called during a Turn
// (gpu_context.h), and throws GpuError where the card fails.
class StationTextures {
 public:
  // With the stations' gains or without, in at most `most_bytes` of the card's memory. The room
  // must outlive the object.
  StationTextures(const Room& room, bool gains, std::uint64_t most_bytes);
  ~StationTextures();
  StationTextures(const StationTextures&) = delete;
  StationTextures& operator=(const StationTextures&) = delete;

  std::size_t layers() const { return keys_.size(); }
  // Uploads those of the stations, at most layers(), that are not there in place of those that were
  // not wanted for longest.
  void require(std::span<const StationKey> stations);
  // Of a station that was required last.
  int layer(StationKey station) const { return at_.at(station); }
  void bind(GLuint unit) const;

 private:
  void upload(StationKey station, int layer);

  const Room& room_;
  bool gains_;
  GLuint texture_ = 0;
  std::uint64_t turn_ = 0;
  std::vector<StationKey> keys_;       // of each layer
  std::vector<std::uint64_t> wanted_;  // when each was wanted last
  std::map<StationKey, int> at_;
};

}  // namespace raywalk
