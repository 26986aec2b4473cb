// Factors between units that files, devices and people use and those that the code computes in.
#pragma once

namespace raywalk {

inline constexpr double kMillimetresPerMetre = 1e3;
inline constexpr double kMsPerSecond = 1e3;
inline constexpr double kBytesPerMegabyte = 1e6;

}  // namespace raywalk
