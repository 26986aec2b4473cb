// What a camera of the Open Spherical Camera API exposes with: choosing it, and telling whether the
// camera keeps to it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera/camera.h"
#include "capture/camera/exif_exposure.h"

namespace raywalk::capture {

// The names of the options that the functions below read, each with its "...Support" list.
const std::vector<std::string>& exposure_option_names();

// The value of the list `<name>Support` nearest to the wanted one by ratio (exposures differ by
// factors). Values that are not positive (0 means automatic) do not count. The wanted value itself
// where the camera lists none. `wanted` is positive.
double nearest_supported(const nlohmann::json& options, const std::string& name, double wanted);
// The value of the list `exposureCompensationSupport` nearest to the wanted one, in EV.
double nearest_compensation(const nlohmann::json& options, double wanted_ev);

// Shutter time and sensitivity as wanted where given; what is missing such that the picture is as
// bright as with `measured`, and of supported values. Throws DeviceFault kExposure if something is
// missing and nothing was measured.
ExifExposure chosen_exposure(const ExposureSettings& wanted,
                             const std::optional<ExifExposure>& measured,
                             const nlohmann::json& options);

// The options that fix the exposure and the white balance: exposureProgram 1, shutterSpeed, iso,
// whiteBalance and, where the camera has it, _colorTemperature. No camera tells which white balance
// it measured; without a wanted one it is the colour temperature that the camera last had, or
// daylight. Throws DeviceFault kExposure if the camera cannot be set to the wanted one.
nlohmann::json locking_options(const ExifExposure& exposure, int white_balance_k,
                               const nlohmann::json& options);

// The same options for an exposure brighter by `ev`: 2^ev times the shutter time, or what is
// nearest.
nlohmann::json bracketed(const nlohmann::json& locking, double ev, const nlohmann::json& options);

// What of the options that were set the camera does not hold, "iso is 0 instead of 100"; empty if
// it holds them all. Numbers may differ by 2 %, for cameras round them.
std::string broken_promise(const nlohmann::json& set, const nlohmann::json& held);
// The same by a picture's Exif data, which are rounded more: exposures may differ by 0.2 EV.
std::string broken_promise(const nlohmann::json& set, const ExifExposure& taken);

}  // namespace raywalk::capture
