// The texts of core/view/shaders, which the build turns into strings.
#pragma once

namespace raywalk {

extern const char* const kGeometryShader;
extern const char* const kMapsShader;
extern const char* const kLookupShader;
extern const char* const kGatheringShader;
extern const char* const kDistancesShader;
extern const char* const kFillShader;
extern const char* const kVisibilityShader;
extern const char* const kQuartersShader;
extern const char* const kEdgesShader;
extern const char* const kMixingShader;
extern const char* const kFlatShader;

}  // namespace raywalk
