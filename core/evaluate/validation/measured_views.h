// Renders true views and scores them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/evaluate/validation/truth_views.h"
#include "core/evaluate/validation/validation_partial.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "core/view/view_mode.h"

namespace raywalk {

inline constexpr int kPageWidth_px = 720;  // of a picture on the page: sharp at half its width

// Indices of the truths that a report shows: a few, spread over the distance from the line.
std::vector<std::size_t> shown_truths(std::span<const TruthView> truths);

// A renderer for each mode, of views of this width. Throws Error as Renderer does.
std::vector<std::unique_ptr<Renderer>> renderers_of(const Room& room,
                                                    std::span<const ViewMode> modes, int width);

// All views, truth by truth and within it mode by mode, each rendered at its truth's width and
// compared with it. Those of shown_truths() have pictures. What is kept in `partial` is not
// rendered again, the others are added to it; prints progress. Throws Error as Renderer and
// read_panorama do; Interrupted.
std::vector<MeasuredView> measured_views(const Room& room, std::span<const TruthView> truths,
                                         std::span<const ViewMode> modes,
                                         const ValidationPartial& partial);

}  // namespace raywalk
