// Points of a room's surfaces with the stations that observe them, as of a sparse reconstruction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "build_lf/export/exported_stations.h"
#include "core/reconstruction/panorama_faces.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Where a station saw a point: in a face of the cube around it.
struct PointObservation {
  int station = 0;  // index of the exported station
  int face = 0;     // of kCubeFaces
  FacePixel pixel{};
  double error_px = 0.0;  // to where the point is in that face
};

struct ObservedPoint {
  Eigen::Vector3d position_m{0, 0, 0};
  std::array<std::uint8_t, 3> colour{0, 0, 0};  // red, green, blue
  std::vector<PointObservation> observations{};
};

struct PointSearch {
  int points = 100'000;         // pixels that are tried, of all maps together
  int face_px = 512;            // side of the faces
  double most_error_px = 0.5;   // of an observation
  double max_distance_m = 0.0;  // of a point from its station; 0: any
  bool gains = true;
};

// Pixels of the distance maps of the stations, evenly over the sphere, that at least two stations
// observe. The point is where the first station's map has it; that station observes it in the
// middle of the pixel. Another station, one of the 12 nearest with a map, observes it if its own
// map shows the same surface there: at the point of that surface which is nearest to it, so that
// maps that disagree, or an oblique view of a wrong distance, show as an error. At most 8 stations
// observe a point. The result does not depend on the number of threads.
std::vector<ObservedPoint> observed_points(const Room& room,
                                           const std::vector<ExportedStation>& stations,
                                           const PointSearch& search);

}  // namespace raywalk::build_lf
