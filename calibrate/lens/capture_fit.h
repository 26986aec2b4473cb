// Lenses from the frames of a capture (see lens_bundle.h).
#pragma once

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// `start` is in the size of the set's pictures. Fills all of LensFit. Throws Error and Interrupted
// as calibrate_lens does.
LensFit fit_to_capture(const CaptureSet& set, const DualFisheyeCamera& start,
                       const LensOptions& options);

}  // namespace raywalk::calibrate
