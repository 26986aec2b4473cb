// Choosing the exposure options of a camera with the Open Spherical Camera API, and checking that
// the camera holds them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera/camera.h"

namespace raywalk::capture {

struct ExifExposure {
  double shutter_s = 0.0;  // more than 0
  int iso = 0;             // more than 0
};

// From the tags ExposureTime and PhotographicSensitivity (Exif 2.32, CIPA DC-008, called
// ISOSpeedRatings before) of a JPEG file; none if one is missing or not positive, or the bytes hold
// no readable Exif data.
std::optional<ExifExposure> exif_exposure(const std::string& jpeg);

// The names of the options that the functions below read, each with its "...Support" list.
const std::vector<std::string>& exposure_option_names();

// The value of the list `<name>Support` nearest to `wanted` > 0 by ratio, as exposures are factors.
// Ignores values that are not positive (0 means automatic). `wanted` itself if there are no others.
double nearest_supported(const nlohmann::json& options, const std::string& name, double wanted);
// The value of the list `exposureCompensationSupport` nearest to `wanted_ev`, in EV.
double nearest_compensation(const nlohmann::json& options, double wanted_ev);

// The supported shutter time and sensitivity nearest to those given by `wanted`; a value that is
// not given is chosen to keep the brightness of `measured`. Throws DeviceFault kExposure if a value
// is missing and nothing was measured.
ExifExposure chosen_exposure(const ExposureSettings& wanted,
                             const std::optional<ExifExposure>& measured,
                             const nlohmann::json& options);

// The options that fix the exposure and the white balance: exposureProgram 1, shutterSpeed, iso,
// whiteBalance and, where the camera has it, _colorTemperature. Cameras do not report the white
// balance that they measured; with `white_balance_k` 0 it is the camera's last colour temperature,
// or daylight. Throws DeviceFault kExposure if the camera cannot be set to `white_balance_k`.
nlohmann::json locking_options(const ExifExposure& exposure, int white_balance_k,
                               const nlohmann::json& options);

// The same options with the shutter time times 2^ev, or the nearest supported one.
nlohmann::json bracketed(const nlohmann::json& locking, double ev, const nlohmann::json& options);

// The first option that the camera does not hold as set, "iso is 0 instead of 100"; empty if it
// holds them all. Numbers may differ by 2 %, because cameras round them.
std::string first_difference(const nlohmann::json& set, const nlohmann::json& held);
// The same from a picture's Exif data, which are rounded more: exposures may differ by 0.2 EV.
std::string first_difference(const nlohmann::json& set, const ExifExposure& taken);

}  // namespace raywalk::capture
