// Pass 4, loops over the rows of a column: the distances of output rows, where they are read in the
// stations, and how much each station counts.
#pragma once

#include <cstdint>

#include "core/geometry/sphere.h"
#include "core/view/column_geometry.h"
#include "core/view/visibility.h"

namespace raywalk {

// Where points of a column at inverse distances are in a station: pixels to the right of the
// column, and rows. `to_eye`: from the station to the eye.
void find_positions(const float* sin_phi, const float* cos_phi, const float* inverse, int rows,
                    Offset to_eye, PanoramaSize captured, float* from_column, float* v);

// The inverse distances `part` of the way from a column to another one, or in it where the two show
// different surfaces.
void interpolate_columns(const float* nearest, const float* other, int rows, float part,
                         float tolerance, float* inverse);

// Rows of the output, each between the row of the distances it is nearest to and the one before or
// after it. `nearest` and `down` as in RowMap. `per_row`: how many there are for each row of the
// distances, from its first one on; 0: not a whole number, or not from the first one on.
struct RowsBetween {
  const int* nearest;
  const float* down;
  int per_row;
  int rows;
  int first() const { return nearest[0]; }
  int last() const { return nearest[rows - 1]; }
};
// 1 where rows [begin, end) and the next one show one surface, else 0.
void find_joined(const float* inverse, int begin, int end, float tolerance, float* joined);
// Values of output rows between those of two rows that are joined and do not differ by `wild`, else
// that of the nearest row. `at` and `joined` are of row 0, and readable one row before and after
// those that are nearest.
void interpolate_rows(const float* at, const float* joined, RowsBetween rows, float wild,
                      float* out);
// Values of the nearest rows.
void repeat_rows(const float* at, RowsBetween rows, float* out);

// How much a station counts: its share, and that where distances are unreliable.
struct StationShare {
  float reliable = 1.0f, unreliable = 1.0f;
};
// The weight of a station, its share where it sees points; where distances are unreliable (`trust`
// below 1; null: nowhere) it counts although it does not seem to. Adds the weights to `total`.
void add_share(const std::uint8_t* occluded, StationOccluders by, const float* trust,
               StationShare share, int rows, float* weight, float* total);

// Weights as parts of their total; whether any is above 0.
bool normalise(const float* weight, const float* total, int rows, float* part);

}  // namespace raywalk
