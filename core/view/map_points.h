// The points of a distance map that views draw.
//
// Points are drawn to find which surface a view sees; how far it is, is read from the map
// afterwards. So one point stands for 2 x 2 pixels where all pixels around them are on one surface.
// At silhouettes every pixel is drawn: gaps between points are closed by what is nearest beside
// them, which would widen what is in front.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/view/column_geometry.h"

namespace raywalk {

struct MapPoints {
  // Points in one plan direction: [begin, end) of the arrays below.
  struct Column {
    double u;    // of the map; half way between two columns where points are 2 x 2 pixels
    int pixels;  // side of each point, 1 or 2
    std::size_t begin, end;
  };

  // `inverse`: inverse distances of a map, [theta][phi], negative where unknown.
  MapPoints(std::span<const float> inverse, PanoramaSize size);

  // Draws the points, as the eyes of a circle see them, into inverse distances [theta][phi] of a
  // view: the nearest stays. `map_m`: where the map was captured. Between points nothing is drawn
  // where fewer than three pixels lie.
  void draw(const Eigen::Vector3d& map_m, const EyeCircle& eye, PanoramaSize view,
            float* image) const;

  PanoramaSize size;
  std::vector<Column> columns;
  std::vector<float> sin_phi, cos_phi, inverse;  // 1/m

 private:
  // Without negative ones.
  void add_column(double u, int pixels, std::span<const float> inverse_of_rows,
                  const Latitudes& latitudes);
};

}  // namespace raywalk
