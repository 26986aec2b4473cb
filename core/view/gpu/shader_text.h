// The text of core/view/shaders/mixing.glsl, which the build turns into a string.
#pragma once

namespace raywalk {

extern const char* const kMixingShader;

}  // namespace raywalk
