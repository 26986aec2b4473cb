// The texts of core/view/shaders, which the build turns into strings.
#pragma once

namespace raywalk {

extern const char *const kGeometryShader, *const kMapsShader, *const kLookupShader,
    *const kGatheringShader, *const kDistancesShader, *const kFillShader, *const kVisibilityShader,
    *const kQuartersShader, *const kEdgesShader, *const kMixingShader;

}  // namespace raywalk
