#include "core/view/view_inputs.h"

namespace raywalk {

int rows_per_distance(const ViewInputs& view) {
  if (view.distances == nullptr || view.layers || view.arithmetic == Arithmetic::kDouble) return 1;
  const int distance_rows = view.distances->size().height;
  const int ratio = view.output.height / distance_rows;
  const bool whole = ratio * distance_rows == view.output.height;
  return whole && (ratio == 2 || ratio == 4 || ratio == 8) ? ratio : 1;
}

RayLayout layout_of(const ViewInputs& view, int line) {
  // Cubic samples are read from neighbouring columns.
  if (rows_per_distance(view) == 1 || view.interpolation == Interpolation::kCubic) {
    return {.stride = {3 * view.room.panorama().height}};
  }
  return view.room.volume(line).layout();
}

}  // namespace raywalk
