// Joins the parts of a grid that were solved one by one: each is moved as a whole by a similarity,
// such that the stations that parts share agree. An adjustment of all poses follows
// (refine_poses.h), in which scene points of all parts count.
#pragma once

#include <span>
#include <vector>

#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/align_poses.h"
#include "calibrate/poses/part_solver.h"
#include "calibrate/poses/refine_poses.h"

namespace raywalk::calibrate {

// Prepares a part to be joined. Moves it to the nominal poses; keeps the points of which the part
// is home to the first frame that sees them, so that no point counts twice, and of these the
// strongest: the adjustment of all has to fit into the memory of one machine.
void thin_for_joining(const PoseProblem& problem, const PosePart& part, RefinedPoses* refined);

// Similarities for the poses of the parts, in the gauge of `fixed` (an index). The poses of frames
// that two parts have in common agree as their sigmas allow, with a Cauchy loss; scales stay near
// 1, as every part has its own from the slider. Parts that share no frames with others are not
// moved. Throws Interrupted.
std::vector<PoseAlignment> similarities(std::span<const FramePoses> parts, std::size_t fixed);

struct JoinedParts {
  FramePoses poses{};   // of the parts that are connected with the largest one, near nominal
  SeenPoints points{};  // points of which two parts saw the same feature are one
};

// `solutions` are those of problem.parts, in order. Nothing if none is solved.
JoinedParts join_parts(const PoseProblem& problem, std::span<const PartSolution> solutions);

}  // namespace raywalk::calibrate
