// The step `rectify` in blocks, on any machines: blocks that compare the light of pairs of frames,
// their merging, blocks of frames, and their merging, in this order. All of it together writes what
// rectify_set writes, to the byte. Each kind of block is kept in OUT/blocks until the end.
#pragma once

#include <cstddef>

#include "calibrate/rectify/rectify_set.h"
#include "core/base/block.h"

namespace raywalk::calibrate {

// Compares the block's share of the pairs of frames; returns their number. Not with
// options.equalise_gain false, when there is nothing to compare: returns 0. Throws as rectify_set.
std::size_t compare_light_block(const CaptureSet& panoramas, const FramePoses& poses,
                                const RectifyOptions& options, Block block);

// Finds the gains of all frames from what was compared. Throws Error naming the blocks that are
// missing.
void merge_light(const CaptureSet& panoramas, const FramePoses& poses,
                 const RectifyOptions& options);

// Writes the block's share of the frames with a pose; returns their number. Throws Error if the
// light has not been merged, and as rectify_set.
std::size_t rectify_block(const CaptureSet& panoramas, const FramePoses& poses,
                          const RectifyOptions& options, Block block);

// Writes what rectify_set writes and removes what the blocks kept. Throws Error naming the blocks
// that are missing, and as rectify_set.
RectifyResult merge_rectified(const CaptureSet& panoramas, const FramePoses& poses,
                              const RectifyOptions& options);

}  // namespace raywalk::calibrate
