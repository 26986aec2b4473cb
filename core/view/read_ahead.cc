#include "core/view/read_ahead.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"
#include "core/view/column_rows.h"

namespace raywalk {
namespace {

constexpr int kColumns = 32;      // of the output, looked at together
constexpr int kRowsBetween = 16;  // of the distances, whose places stand for those between

// Fetches columns [first, end) of a station, around the seam.
void fetch_columns(const LineVolume& volume, int station, int first, int end) {
  const PanoramaSize size = volume.panorama();
  const auto bytes = [&](int columns) {
    return static_cast<std::size_t>(columns) * 3 * static_cast<std::size_t>(size.height);
  };
  const int count = std::min(end - first, size.width);
  const int from = wrapped_column(first, size.width);
  if (volume.in_memory(station, wrapped_column(first + count / 2, size.width))) return;
  const int before_seam = std::min(count, size.width - from);
  volume.fetch(station, bytes(from), bytes(before_seam));
  if (count > before_seam) volume.fetch(station, 0, bytes(count - before_seam));
}

// The columns of a station, from that of the output column on, that a column's points lie in.
struct Reach {
  float least = 0.0f, most = 0.0f;
};
Reach reach_of(const MixedView& view, int theta, int line, int station) {
  std::vector<float> sin_phi, cos_phi, inverse;
  for (int row = 0; row < view.distances.size().height; row += kRowsBetween) {
    const auto i = static_cast<std::size_t>(row);
    sin_phi.push_back(view.distances.latitudes().sin_phi[i]);
    cos_phi.push_back(view.distances.latitudes().cos_phi[i]);
    inverse.push_back(view.distances.column(theta)[row]);
  }
  const double theta_rad = theta_of_column(theta, view.distances.size().width);
  const Eigen::Vector3d to_eye_m =
      view.distances.eye().position_m(theta_rad) - view.room.grid()
                                                       .lines[static_cast<std::size_t>(line)]
                                                       .stations[static_cast<std::size_t>(station)]
                                                       .position_m;
  std::vector<float> from_column(inverse.size()), v(inverse.size());
  find_positions(sin_phi.data(), cos_phi.data(), inverse.data(), static_cast<int>(inverse.size()),
                 offset_in_column(to_eye_m, theta_rad), view.room.panorama(), from_column.data(),
                 v.data());
  const auto [least, most] = std::ranges::minmax(from_column);
  return {least, most};
}

}  // namespace

void read_ahead(const MixedView& view, const PanoramaPart& part) {
  const bool initial = view.options.method == ViewMethod::kInitial;
  const double captured_per_output =
      static_cast<double>(view.room.panorama().width) / view.output.width;
  parallel_for(0, (part.columns + kColumns - 1) / kColumns, 1, [&](int begin, int end) {
    for (int block = begin; block < end; ++block) {
      const int first = part.first_column + block * kColumns;
      const double middle = first + 0.5 * (kColumns - 1);
      const double theta_rad = theta_of_column(middle, view.output.width);
      const ColumnSources sources = view.sources(theta_rad);
      const int maps = view.distances.size().width;
      const double in_maps = (middle + 0.5) * maps / view.output.width - 0.5;
      const int theta = initial ? 0 : wrapped_column(static_cast<int>(std::lround(in_maps)), maps);
      for (std::size_t i = 0; i < sources.count; ++i) {
        const RaySource& at = sources.source[i].at;
        const LineVolume& volume = view.room.volume(at.line);
        const StationWindow window =
            initial ? StationWindow{at.station, at.station + 1}
                    : stations_mixed(at, volume.stations(), station_mix(view.options));
        for (int station = window.first; station <= window.last; ++station) {
          const Reach reach = initial ? Reach() : reach_of(view, theta, at.line, station);
          fetch_columns(
              volume, station, static_cast<int>(first * captured_per_output + reach.least) - 1,
              static_cast<int>((first + kColumns) * captured_per_output + reach.most) + 2);
        }
      }
    }
  });
}

}  // namespace raywalk
