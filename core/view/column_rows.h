// Pass 4, loops over the rows of a column: where they are read in the stations, and how much each
// station counts.
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

// The part of the way from column a to column b of the distances at which a row is read: that of
// the output column, or the nearer end where the two show different surfaces. And the distance
// there.
void find_parts(const float* a, const float* b, int rows, float part, float tolerance, float* parts,
                float* inverse);

// 1 where a row and the next show different surfaces.
void find_steps(const float* inverse, int rows, float tolerance, float* step);

// Values between those of two columns. What is between the eye and a station is behind the station,
// on its left in one column and on its right in the next: `turn` is after how much values go round.
void between_columns(const float* a, const float* b, const float* part, int rows, float turn,
                     float* out);

// How rows of the output lie between those of the distances: `upper`, counted like `first_upper`,
// is the first of the two around each, `part` that of the way to the second. `per_row`: how many
// there are for each row of the distances; 0: not a whole number.
struct RowsBetween {
  const int* upper;
  const float* part;
  int first_upper;
  int per_row;
  int rows;
};
// Values of output rows. Across a step, and where values jump by more than `wild`, those of the
// nearer row.
void between_rows(const float* at, const float* step, RowsBetween rows, float wild, float* out);

// How much a station counts: its share, and that where distances are unreliable.
struct StationShare {
  float reliable = 1.0f, unreliable = 1.0f;
};
// The weight of a station, its share where it sees points; where distances are unreliable (`trust`
// below 1; null: nowhere) it counts although it does not seem to. Adds the weights to `total`.
void add_share(const std::uint8_t* occluded, StationOccluders by, const float* trust,
               StationShare share, int rows, float* weight, float* total);

// The weights in 1/kWeightOne, as parts of the total.
void normalise(const float* weight, const float* total, int rows, std::int16_t* part);

}  // namespace raywalk
