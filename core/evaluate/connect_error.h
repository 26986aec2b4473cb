// E_connect, equation (11) of the paper: how much the pictures of two lines differ where a view
// changes from one to the other.
//
// At each corner of a cell, and for each k, the lines connect at clamp(c, 90 deg - k, k)
// (connection.h), regardless of the overhang. The overlap is that angle plus and minus half the
// blend. In it, every output column whose ray crosses the captured part of both lines is rendered
// from each line alone, and the two are compared.
//
// E_connect is the mean squared difference of 8-bit red, green and blue over all these columns of
// all viewpoints. (11) averages the viewpoints' means instead, which is the same where each has the
// same number of columns; where some overlaps are only partly captured, a single column would then
// count as much as a whole overlap. A k near 45 degrees reads far beyond the corners, so that
// without much overhang it is measured on other (viewpoint, corner) pairs than a k near 90:
// `coverage` gives their share, and `e_connect_common` uses the same pairs for all k.
//
// A view "from one line" is, by method:
//   initial    the vertical cut through the line;
//   hlf-vd     the same corrected by (5), with hidden pixels filled as in any view;
//   two-sided  the corrected view from the line and from what the plan has behind the viewpoint,
//              which both lines have in common: the step that is seen where one line in front gives
//              way to the other. The plan is that of k = 90, so that it serves every k.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_options.h"

namespace raywalk {

// k = 45, 50, ..., 70, 72, ..., 88, 90 degrees.
std::vector<double> default_k_list_deg();

struct ConnectErrorOptions {
  int viewpoints = 49;       // n per side: centres of n x n sub-cells of every cell, 1..250
  double overlap_deg = 5.0;  // the whole width, above 0 and up to 45
  std::vector<double> k_list_deg = default_k_list_deg();  // each in 45..90
};

// Viewpoints per side of a cell that suffice for a room: 49, and where there are more than 24 cells
// so many fewer, but at least 2, that all of them together have about as many.
int viewpoints_for(std::size_t cells);

// Throws UsageError for an option out of range.
void require_connect_error_options(const ConnectErrorOptions& options);

// Measured at all viewpoints, cell by cell, at the size of the room's panoramas; prints progress.
// Does not depend on the number of threads. Throws UsageError for an option out of range; Error if
// the room has no cell or lacks the distances that the method needs; Interrupted.
//
// {"connection": {"viewpoints", "overlap_deg",
//                 "common_share": of the (viewpoint, corner) pairs: readable at every k,
//                 "comparable": whether these are enough},
//  "rows": [for each k of the list, in its order:
//           {"connection": "lfu", "hybrid" or "rayspace360", "k_deg", "method", "e_connect",
//            "e_connect_common": over the pairs that are readable at every k,
//            "coverage": share of the pairs with a column to compare}]}
// Errors are in squared 8-bit levels, NaN where there was no column.
nlohmann::ordered_json measure_connect_error(const Room& room, ViewMethod method,
                                             const ConnectErrorOptions& options);

// As a table of text, one line per k.
std::string connect_error_table(const nlohmann::ordered_json& measured);

}  // namespace raywalk
