// A rendering mode as it is reported: the renderer's options, and how k was chosen.
#pragma once

#include <string>

#include "core/view/renderer.h"

namespace raywalk {

struct ViewMode {
  ViewOptions options{};
  std::string connection = "hybrid";  // "hybrid", "lfu" or "rayspace360"
  std::string k_source{};             // how options.k_deg was chosen, for the user
};

}  // namespace raywalk
