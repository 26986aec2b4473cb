// Hold-out measurement: how well stations that a part of a room lacks are rendered from it.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "build_lf/require/facts.h"
#include "core/evaluate/held_out.h"
#include "core/room/room.h"
#include "core/view/renderer.h"

namespace raywalk::build_lf {

// PSNR of the view at a station's place against what was captured there, which is reduced to the
// size of the view; at most kMaxPsnrDb, also where the station is masked completely. Masked pixels
// are not compared.
double psnr_of_view(const cv::Mat& view, const TrueView& captured);

// For strides 2, 3, 4, 6, 8, ...: keeps the stations that --thin would keep at so many captured
// steps, with their distance maps, and renders the middle ones of the gaps, which are the hardest,
// with distances (hlf-vd) and without (initial); a dozen per stride, spread over the room. Without
// a distance map among those kept both are views without distances. Gains are not applied. Empty if
// no line has three stations. `tolerance_px` is for psnr_of_tolerance_db. Throws Interrupted.
std::vector<HeldOutFacts> measure_strides(const Room& room, double captured_step_m,
                                          double tolerance_px);

// The largest step, metres, such that for it and all smaller ones the PSNR of stations re-created
// with distances is at least that of the tolerance. 0 if there is none.
double measured_up_to_m(std::span<const HeldOutFacts> strides);

// Compares a thinned room with its source: re-creates dropped stations from it, at most 48 spread
// over the room. 100 dB if none was dropped. `kept` must include a station with a distance map.
ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept,
                           const std::filesystem::path& out);

}  // namespace raywalk::build_lf
