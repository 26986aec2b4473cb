#include "core/view/edges.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// 1 where a row differs from one of its four neighbours by a step.
RAYWALK_VECTOR_CLONES void mark_steps(const float* left, const float* here, const float* right,
                                      int rows, float tolerance, std::uint8_t* step) {
  const auto differ = [tolerance](float a, float b) {
    return std::fabs(a - b) > tolerance * (a > b ? a : b);
  };
  for (int v = 0; v < rows; ++v) {
    step[v] = static_cast<std::uint8_t>(static_cast<int>(differ(here[v], left[v])) |
                                        static_cast<int>(differ(here[v], right[v])));
  }
  for (int v = 1; v < rows; ++v) {
    const auto below = static_cast<std::uint8_t>(differ(here[v - 1], here[v]));
    step[v - 1] |= below;
    step[v] |= below;
  }
}

// The nearest and the farthest surface of the 3 x 3 pixels around one; beyond a pole its own row is
// repeated.
struct SurfacesAround {
  EdgeQuarter nearest{}, farthest{};
};
SurfacesAround surfaces_around(const std::array<const float*, 3>& columns, int row, int rows) {
  const EdgeQuarter own{.inverse = columns[1][row]};
  SurfacesAround around{own, own};
  for (int right = -1; right <= 1; ++right) {
    const int beside = right + 1;
    const float* const column = columns[static_cast<std::size_t>(beside)];
    for (int down = -1; down <= 1; ++down) {
      const EdgeQuarter other{.inverse = column[std::clamp(row + down, 0, rows - 1)],
                              .right = static_cast<std::int8_t>(right),
                              .down = static_cast<std::int8_t>(down)};
      if (other.inverse > around.nearest.inverse) around.nearest = other;
      if (other.inverse < around.farthest.inverse) around.farthest = other;
    }
  }
  return around;
}

// Finds the edges of columns.
class EdgeFinder {
 public:
  explicit EdgeFinder(const DistanceView& distances)
      : distances_(distances), step_(static_cast<std::size_t>(distances.size().height)) {}

  void find(int theta, std::vector<EdgePixel>* pixels) {
    const PanoramaSize size = distances_.size();
    const std::array<const float*, 3> columns{
        distances_.column(wrapped_column(theta - 1, size.width)), distances_.column(theta),
        distances_.column(wrapped_column(theta + 1, size.width))};
    mark_steps(columns[0], columns[1], columns[2], size.height, distances_.surface_tolerance(),
               step_.data());
    pixels->clear();
    around_.clear();
    for (int row = 0; row < size.height; ++row) {
      if (step_[static_cast<std::size_t>(row)] == 0) continue;
      const EdgeQuarter own{.inverse = columns[1][row]};
      pixels->push_back({row, {own, own, own, own}});
      around_.push_back(surfaces_around(columns, row, size.height));
    }
    if (pixels->empty()) return;
    for (const std::size_t side : {0, 1}) find_quarters(theta, side, pixels);
  }

 private:
  // A quarter that no map has shown yet.
  struct Unknown {
    std::size_t pixel, lower;
  };

  // The quarters on one side, two of each pixel.
  void find_quarters(int theta, std::size_t side, std::vector<EdgePixel>* pixels) {
    unknown_.clear();
    for (std::size_t pixel = 0; pixel < pixels->size(); ++pixel) {
      for (const std::size_t lower : {0, 1}) unknown_.push_back({pixel, lower});
    }
    const double theta_rad =
        theta_of_column(theta + (side == 0 ? -0.25 : 0.25), distances_.size().width);
    for (const ColumnLookup& map : distances_.lookups(theta_rad)) {
      take_from(map, &SurfacesAround::nearest, side, pixels);
      take_from(map, &SurfacesAround::farthest, side, pixels);
      if (unknown_.empty()) break;
    }
  }

  // Puts unknown quarters on a surface where a map shows it.
  void take_from(const ColumnLookup& map, EdgeQuarter SurfacesAround::*surface, std::size_t side,
                 std::vector<EdgePixel>* pixels) {
    const std::size_t count = unknown_.size();
    for (auto* values : {&sin_phi_, &cos_phi_, &inverse_, &part_, &held_}) values->resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [pixel, lower] = unknown_[i];
      const Latitude latitude =
          distances_.latitudes().beside((*pixels)[pixel].row, lower == 0 ? -0.25f : 0.25f);
      sin_phi_[i] = latitude.sin_phi;
      cos_phi_[i] = latitude.cos_phi;
      inverse_[i] = (around_[pixel].*surface).inverse;
    }
    look_up_points(map, sin_phi_.data(), cos_phi_.data(), inverse_.data(), static_cast<int>(count),
                   distances_.surface_tolerance(), part_.data(), held_.data());
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Unknown at = unknown_[i];
      if (part_[i] < 0.5f) {
        unknown_[left++] = at;
        continue;
      }
      EdgeQuarter& quarter = (*pixels)[at.pixel].quarter[2 * side + at.lower];
      quarter = around_[at.pixel].*surface;
      quarter.inverse = held_[i];
    }
    unknown_.resize(left);
  }

  const DistanceView& distances_;
  std::vector<std::uint8_t> step_;
  std::vector<SurfacesAround> around_;  // of each edge pixel
  std::vector<Unknown> unknown_;
  std::vector<float> sin_phi_, cos_phi_, inverse_, part_, held_;
};

}  // namespace

void Edges::compute(const DistanceView& distances, int first, int count) {
  columns_.resize(static_cast<std::size_t>(distances.size().width));
  parallel_for(0, count, 16, [&](int begin, int end) {
    EdgeFinder finder(distances);
    for (int i = begin; i < end; ++i) {
      const int theta = wrapped_column(first + i, distances.size().width);
      finder.find(theta, &columns_[static_cast<std::size_t>(theta)]);
    }
  });
}

}  // namespace raywalk
