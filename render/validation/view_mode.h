// One way of rendering views, as it is reported: what the renderer is told, and how that was
// chosen.
#pragma once

#include <string>

#include "render/view/renderer.h"

namespace raywalk::render {

struct ViewMode {
  ViewOptions options{};
  std::string connection = "hybrid";  // "hybrid", "lfu" or "rayspace360"
  std::string k_source{};             // where options.k_deg comes from, in words
};

}  // namespace raywalk::render
