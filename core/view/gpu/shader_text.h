// The texts of core/view/shaders, which the build turns into strings.
#pragma once

namespace raywalk {

extern const char *const kGeometryShader, *const kMapsShader, *const kDistancesShader,
    *const kFillShader, *const kVisibilityShader, *const kEdgesShader, *const kMixingShader;

}  // namespace raywalk
