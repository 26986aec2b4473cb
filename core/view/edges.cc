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

// What a map shows at points.
RAYWALK_VECTOR_CLONES void look_up_points(ColumnLookup map, const float* sin_phi,
                                          const float* cos_phi, const float* inverse, int count,
                                          float tolerance, float* part, float* held) {
  RAYWALK_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const HeldPoint point = look_up_point(map, sin_phi[i], cos_phi[i], inverse[i], tolerance);
    part[i] = point.part;
    held[i] = point.inverse;
  }
}

// The 5 x 5 pixels around one; beyond a pole its own row is repeated.
struct PixelsAroundEdge {
  std::array<const float*, 5> column{};
  int row = 0, rows = 0;

  float at(int right, int down) const {
    const int beside = right + 2;
    return column[static_cast<std::size_t>(beside)][std::clamp(row + down, 0, rows - 1)];
  }
};

// A surface at an edge: that of one of the 3 x 3 pixels around.
struct EdgeSurface {
  float inverse = 0.0f;
  std::int8_t right = 0, down = 0;
  // The middle of those of the 5 x 5 pixels around that are on it, from the pixel's own.
  float middle_right = 0.0f, middle_down = 0.0f;
};
struct EdgeSurfaces {
  EdgeSurface own{}, nearest{}, farthest{};
};

void find_middle(const PixelsAroundEdge& around, float tolerance, EdgeSurface* surface) {
  float right = 0.0f, down = 0.0f, count = 0.0f;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      const float other = around.at(x, y);
      const float larger = std::max(other, surface->inverse);
      const float on = std::fabs(other - surface->inverse) <= tolerance * larger ? 1.0f : 0.0f;
      right += on * static_cast<float>(x);
      down += on * static_cast<float>(y);
      count += on;
    }
  }
  surface->middle_right = right / count;  // its own pixel is one of them
  surface->middle_down = down / count;
}

EdgeSurfaces surfaces_around(const PixelsAroundEdge& around, float tolerance) {
  const EdgeSurface own{.inverse = around.at(0, 0)};
  EdgeSurfaces surfaces{own, own, own};
  for (std::int8_t right = -1; right <= 1; ++right) {
    for (std::int8_t down = -1; down <= 1; ++down) {
      const EdgeSurface other{.inverse = around.at(right, down), .right = right, .down = down};
      if (other.inverse > surfaces.nearest.inverse) surfaces.nearest = other;
      if (other.inverse < surfaces.farthest.inverse) surfaces.farthest = other;
    }
  }
  for (EdgeSurface* surface : {&surfaces.own, &surfaces.nearest, &surfaces.farthest}) {
    find_middle(around, tolerance, surface);
  }
  return surfaces;
}

// The middles of quarters are this far from that of their pixel.
float from_middle(std::size_t side) { return side == 0 ? -0.25f : 0.25f; }

// A quarter on a surface. Its sample is moved towards the middle of that surface.
EdgeQuarter quarter_on(const EdgeSurface& surface, float inverse, std::size_t side,
                       std::size_t lower) {
  constexpr float kPart = 0.2f;  // of the way: more blurs what is on the surface
  return {.inverse = inverse,
          .right_px = kPart * (surface.middle_right - from_middle(side)),
          .down_px = kPart * (surface.middle_down - from_middle(lower)),
          .right = surface.right,
          .down = surface.down};
}

// Finds the edges of columns.
class EdgeFinder {
 public:
  explicit EdgeFinder(const DistanceView& distances)
      : distances_(distances), step_(static_cast<std::size_t>(distances.size().height)) {}

  void find(int theta, std::vector<EdgePixel>* pixels) {
    const PanoramaSize size = distances_.size();
    around_.rows = size.height;
    for (int i = 0; i < 5; ++i) {
      around_.column[static_cast<std::size_t>(i)] =
          distances_.column(wrapped_column(theta + i - 2, size.width));
    }
    mark_steps(around_.column[1], around_.column[2], around_.column[3], size.height,
               distances_.surface_tolerance(), step_.data());
    pixels->clear();
    surfaces_.clear();
    for (int row = 0; row < size.height; ++row) {
      if (step_[static_cast<std::size_t>(row)] == 0) continue;
      around_.row = row;
      pixels->push_back({.row = row});
      surfaces_.push_back(surfaces_around(around_, distances_.surface_tolerance()));
    }
    if (pixels->empty()) return;
    for (const std::size_t side : {0, 1}) find_quarters(theta, side, pixels);
  }

 private:
  // The quarters on one side, two of each pixel.
  void find_quarters(int theta, std::size_t side, std::vector<EdgePixel>* pixels) {
    const PanoramaSize size = distances_.size();
    const std::size_t count = 2 * pixels->size();
    for (auto* values : {&sin_phi_, &cos_phi_, &nearest_, &farthest_, &part_, &held_}) {
      values->resize(count);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Latitude latitude =
          distances_.latitudes().beside((*pixels)[i / 2].row, from_middle(i % 2));
      sin_phi_[i] = latitude.sin_phi;
      cos_phi_[i] = latitude.cos_phi;
      nearest_[i] = surfaces_[i / 2].nearest.inverse;
      farthest_[i] = surfaces_[i / 2].farthest.inverse;
    }
    known_.assign(count, 0);
    const double theta_rad = theta_of_column(theta + double(from_middle(side)), size.width);
    for (const ColumnLookup& map : distances_.lookups(theta_rad)) {
      if (std::ranges::find(known_, 0) == known_.end()) break;
      take_from(map, nearest_, &EdgeSurfaces::nearest, side, pixels);
      take_from(map, farthest_, &EdgeSurfaces::farthest, side, pixels);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (known_[i] != 0) continue;
      const EdgeSurface& own = surfaces_[i / 2].own;
      (*pixels)[i / 2].quarter[2 * side + i % 2] = quarter_on(own, own.inverse, side, i % 2);
    }
  }

  // Puts quarters that are not known on a surface where a map shows it.
  void take_from(const ColumnLookup& map, const std::vector<float>& inverse,
                 EdgeSurface EdgeSurfaces::*surface, std::size_t side,
                 std::vector<EdgePixel>* pixels) {
    look_up_points(map, sin_phi_.data(), cos_phi_.data(), inverse.data(),
                   static_cast<int>(inverse.size()), distances_.surface_tolerance(), part_.data(),
                   held_.data());
    for (std::size_t i = 0; i < inverse.size(); ++i) {
      if (known_[i] != 0 || part_[i] < 0.5f) continue;
      const EdgeSurface& on = surfaces_[i / 2].*surface;
      (*pixels)[i / 2].quarter[2 * side + i % 2] = quarter_on(on, held_[i], side, i % 2);
      known_[i] = 1;
    }
  }

  const DistanceView& distances_;
  PixelsAroundEdge around_;
  std::vector<std::uint8_t> step_;
  std::vector<EdgeSurfaces> surfaces_;  // of each edge pixel
  // Of the quarters on one side.
  std::vector<float> sin_phi_, cos_phi_, nearest_, farthest_, part_, held_;
  std::vector<std::uint8_t> known_;
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
