#include "simulator/rig/osc_api.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

// HTTP status of the Theta's error codes: disabledCommand 403, serviceUnavailable 503, others 400.
int http_status_of(const std::string& code) {
  if (code == "disabledCommand") return 403;
  if (code == "serviceUnavailable") return 503;
  return 400;
}

OscReply error_reply(const std::string& name, const CommandRefused& refused) {
  Json reply = {{"state", "error"},
                {"error", {{"code", refused.code()}, {"message", refused.what()}}}};
  if (!name.empty()) reply["name"] = name;
  return {http_status_of(refused.code()), reply.dump()};
}

OscReply done_reply(const std::string& name, const Json& results) {
  Json reply = {{"name", name}, {"state", "done"}};
  if (!results.is_null()) reply["results"] = results;
  return {200, reply.dump()};
}

// Value of a parameter. Throws the API's errors if it is missing or has a wrong type.
template <typename T>
T parameter(const Json& parameters, const char* key) {
  if (!parameters.contains(key)) {
    throw CommandRefused("missingParameter", std::string("Parameter ") + key + " is missing.");
  }
  try {
    return parameters.at(key).get<T>();
  } catch (const Json::exception&) {
    throw CommandRefused("invalidParameterValue",
                         std::string("Parameter ") + key + " has a wrong type.");
  }
}

Json parse(const std::string& body) {
  Json request = Json::parse(body, nullptr, false);
  if (!request.is_object()) {
    throw CommandRefused("invalidParameterValue", "The request is not a JSON object.");
  }
  return request;
}

std::string url_of(const std::string& base_url, const std::string& name) {
  return name.empty() ? std::string{} : base_url + "/files/" + name;
}

// The name in a file's URL.
std::string name_in(const std::string& url) { return url.substr(url.find_last_of('/') + 1); }

// --- Options ------------------------------------------------------------------------------------

std::string date_time_zone(WallTime time) {
  return fmt::format("{:%Y:%m:%d %H:%M:%S}+00:00",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

Json file_format(const SimulatedCamera& camera) {
  const PanoramaSize frame = camera.settings().frame;
  return {{"type", "jpeg"}, {"width", frame.width}, {"height", frame.height}};
}

// With an automatic exposure program the Theta only supports 0 (automatic).
Json manual_only(const SimulatedCamera& camera, const Json& values) {
  return camera.options().exposure_program == 1 ? values : Json::array({0});
}

using OptionReader = std::function<Json(SimulatedCamera&)>;

const std::map<std::string, OptionReader>& option_readers() {
  static const std::map<std::string, OptionReader> readers = {
      {"captureMode", [](SimulatedCamera&) { return Json("image"); }},
      {"captureModeSupport", [](SimulatedCamera&) { return Json::array({"image"}); }},
      {"exposureProgram", [](SimulatedCamera& c) { return Json(c.options().exposure_program); }},
      {"exposureProgramSupport",
       [](SimulatedCamera&) {
         return Json::array({1, 2});
       }},
      {"shutterSpeed", [](SimulatedCamera& c) { return Json(c.options().shutter_s); }},
      {"shutterSpeedSupport",
       [](SimulatedCamera& c) { return manual_only(c, camera_support().shutter_s); }},
      {"iso", [](SimulatedCamera& c) { return Json(c.options().iso); }},
      {"isoSupport", [](SimulatedCamera& c) { return manual_only(c, camera_support().iso); }},
      {"exposureCompensation",
       [](SimulatedCamera& c) { return Json(c.options().compensation_ev); }},
      {"exposureCompensationSupport",
       [](SimulatedCamera&) { return Json(camera_support().compensation_ev); }},
      {"whiteBalance", [](SimulatedCamera& c) { return Json(c.options().white_balance); }},
      {"whiteBalanceSupport",
       [](SimulatedCamera&) { return Json(camera_support().white_balance); }},
      {"_colorTemperature",
       [](SimulatedCamera& c) { return Json(c.options().color_temperature_k); }},
      {"fileFormat", [](SimulatedCamera& c) { return file_format(c); }},
      {"fileFormatSupport", [](SimulatedCamera& c) { return Json::array({file_format(c)}); }},
      {"dateTimeZone", [](SimulatedCamera& c) { return Json(date_time_zone(c.wall_now())); }},
      {"remainingPictures", [](SimulatedCamera& c) { return Json(c.pictures_left()); }},
      {"remainingSpace", [](SimulatedCamera& c) { return Json(c.card().free_bytes()); }},
      {"totalSpace", [](SimulatedCamera& c) { return Json(c.card().capacity_bytes()); }},
  };
  return readers;
}

Json get_options(SimulatedCamera& camera, const Json& parameters) {
  Json options = Json::object();
  for (const std::string& name : parameter<std::vector<std::string>>(parameters, "optionNames")) {
    const auto reader = option_readers().find(name);
    const bool untold = name.starts_with("fileFormat") && camera.settings().frame.width == 0;
    if (reader == option_readers().end() || untold) {
      throw CommandRefused("invalidParameterName", "Option " + name + " is not supported.");
    }
    options[name] = reader->second(camera);
  }
  return {{"options", options}};
}

using OptionWriter = std::function<void(const Json&, const char*, CameraOptions&)>;

const std::map<std::string, OptionWriter>& option_writers() {
  static const std::map<std::string, OptionWriter> writers = {
      {"exposureProgram",
       [](const Json& from, const char* key, CameraOptions& to) {
         to.exposure_program = parameter<int>(from, key);
       }},
      {"shutterSpeed", [](const Json& from, const char* key,
                          CameraOptions& to) { to.shutter_s = parameter<double>(from, key); }},
      {"iso", [](const Json& from, const char* key,
                 CameraOptions& to) { to.iso = parameter<int>(from, key); }},
      {"exposureCompensation",
       [](const Json& from, const char* key, CameraOptions& to) {
         to.compensation_ev = parameter<double>(from, key);
       }},
      {"whiteBalance",
       [](const Json& from, const char* key, CameraOptions& to) {
         to.white_balance = parameter<std::string>(from, key);
       }},
      {"_colorTemperature",
       [](const Json& from, const char* key, CameraOptions& to) {
         to.color_temperature_k = parameter<int>(from, key);
       }},
      {"captureMode",
       [](const Json& from, const char* key, CameraOptions&) {
         if (parameter<std::string>(from, key) != "image") {
           throw CommandRefused("invalidParameterValue", "Only captureMode image is supported.");
         }
       }},
  };
  return writers;
}

Json set_options(SimulatedCamera& camera, const Json& parameters) {
  const Json wanted = parameter<Json>(parameters, "options");
  if (!wanted.is_object()) {
    throw CommandRefused("invalidParameterValue", "Parameter options has a wrong type.");
  }
  CameraOptions options = camera.options();
  for (const auto& [name, value] : wanted.items()) {
    const auto writer = option_writers().find(name);
    if (writer == option_writers().end()) {
      throw CommandRefused("invalidParameterName", "Option " + name + " cannot be set.");
    }
    writer->second(wanted, name.c_str(), options);
  }
  camera.set_options(options);
  return nullptr;
}

// --- Files --------------------------------------------------------------------------------------

// Newest first, as the Theta lists them.
Json list_files(SimulatedCamera& camera, const Json& parameters, const std::string& base_url) {
  const auto count = parameter<std::size_t>(parameters, "entryCount");
  const std::size_t start = parameters.value("startPosition", std::size_t{0});
  const std::vector<SimulatedCardFile> files = camera.card().files();
  Json entries = Json::array();
  for (std::size_t i = start; i < files.size() && entries.size() < count; ++i) {
    const SimulatedCardFile& file = files[files.size() - 1 - i];
    entries.push_back({{"name", file.name},
                       {"fileUrl", url_of(base_url, file.name)},
                       {"size", file.bytes},
                       {"isProcessed", true},
                       {"previewUrl", ""}});
  }
  return {{"entries", entries}, {"totalEntries", files.size()}};
}

Json delete_files(SimulatedCamera& camera, const Json& parameters) {
  for (const std::string& url : parameter<std::vector<std::string>>(parameters, "fileUrls")) {
    try {
      camera.card().erase(name_in(url));
    } catch (const Error& error) {
      throw CommandRefused("invalidParameterValue", error.what());
    }
  }
  return nullptr;
}

Json progress_reply(const PictureProgress& progress, const std::string& id,
                    const std::string& base_url) {
  Json reply = {{"name", "camera.takePicture"}, {"id", id}};
  if (!progress.done) {
    reply["state"] = "inProgress";
    reply["progress"] = {{"completion", progress.completion}};
  } else {
    reply["state"] = "done";
    // A camera that failed to take the picture reports done without a file.
    reply["results"] = Json::object();
    if (!progress.camera_name.empty()) {
      reply["results"]["fileUrl"] = url_of(base_url, progress.camera_name);
    }
  }
  return reply;
}

OscReply run_command(SimulatedCamera& camera, const std::string& name, const Json& parameters,
                     const std::string& base_url) {
  if (name == "camera.getOptions") return done_reply(name, get_options(camera, parameters));
  if (name == "camera.setOptions") return done_reply(name, set_options(camera, parameters));
  if (name == "camera.listFiles") return done_reply(name, list_files(camera, parameters, base_url));
  if (name == "camera.delete") return done_reply(name, delete_files(camera, parameters));
  if (name == "camera.takePicture") {
    const std::string id = camera.take_picture();
    return {200, progress_reply({}, id, base_url).dump()};
  }
  throw CommandRefused("unknownCommand", "Command executed is unknown.");
}

}  // namespace

OscReply OscApi::info() const {
  const SimulatedCameraSettings& settings = camera_.settings();
  const Json reply = {
      {"manufacturer", "Raywalk"},
      {"model", settings.model},
      {"serialNumber", settings.serial_number},
      {"firmwareVersion", settings.firmware_version},
      {"supportUrl", ""},
      {"gps", false},
      {"gyro", false},
      {"uptime", 0},
      {"api", {"/osc/info", "/osc/state", "/osc/commands/execute", "/osc/commands/status"}},
      {"apiLevel", {2}}};
  return {200, reply.dump()};
}

OscReply OscApi::state(const std::string& base_url) const {
  const bool exposing = camera_.is_exposing();
  const bool full = camera_.pictures_left() < 1;
  const Json state = {{"batteryLevel", camera_.settings().battery_share},
                      {"storageUri", base_url + "/files/"},
                      {"_captureStatus", exposing ? "shooting" : "idle"},
                      {"_latestFileUrl", url_of(base_url, camera_.last_file())},
                      {"_batteryState", "disconnect"},
                      {"_apiVersion", 2},
                      {"_cameraError", full ? Json::array({"NO_MEMORY"}) : Json::array()}};
  const std::string fingerprint =
      fmt::format("FIG_{}_{}", camera_.pictures_taken(), exposing ? 1 : 0);
  return {200, Json{{"fingerprint", fingerprint}, {"state", state}}.dump()};
}

OscReply OscApi::execute(const std::string& body, const std::string& base_url) {
  std::string name;
  try {
    const Json request = parse(body);
    name = parameter<std::string>(request, "name");
    const Json parameters = request.value("parameters", Json::object());
    return run_command(camera_, name, parameters, base_url);
  } catch (const CommandRefused& refused) {
    return error_reply(name, refused);
  }
}

OscReply OscApi::status(const std::string& body, const std::string& base_url) const {
  try {
    const auto id = parameter<std::string>(parse(body), "id");
    return {200, progress_reply(camera_.progress_of(id), id, base_url).dump()};
  } catch (const CommandRefused& refused) {
    return error_reply({}, refused);
  }
}

}  // namespace raywalk::capture
