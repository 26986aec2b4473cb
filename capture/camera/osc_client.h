// A client of the Open Spherical Camera API over HTTP.
//
// Sources: developers.google.com/streetview/open-spherical-camera (levels 1 and 2); the Ricoh Theta
// Web API v2.0 and v2.1 (github.com/ricohapi/theta-api-specs); Insta360's
// github.com/Insta360Develop/Insta360_OSC.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/clock.h"
#include "capture/base/device_fault.h"
#include "capture/camera/camera_config.h"

namespace httplib {
class Client;
}  // namespace httplib

namespace raywalk::capture {

// Members of a JSON object from a camera, which may be missing or of any type: empty if it is not a
// text; none if it is not a number; an empty list if it is not a list.
std::string text_at(const nlohmann::json& object, const char* key);
std::optional<double> number_at(const nlohmann::json& object, const char* key);
nlohmann::json list_at(const nlohmann::json& object, const std::string& key);

// The camera rejected a command. what() is the API's message.
class OscRefusal : public std::runtime_error {
 public:
  OscRefusal(std::string code, const std::string& message)
      : std::runtime_error(message), code_(std::move(code)) {}
  // Whether the same command may succeed later.
  bool is_temporary() const;
  // " (disabledCommand: not in image mode)"
  std::string in_parentheses() const { return " (" + code_ + ": " + what() + ")"; }

 private:
  std::string code_;
};

// A command that was started.
struct OscCommand {
  bool done = false;
  std::string id;    // for status_of; empty once done
  std::string file;  // of a picture, once done; empty if the results name none
};

// Reads without a reply, or with an empty one, are repeated twice. A command that changes something
// may have been executed although its reply was lost, and is repeated only if that is harmless. All
// calls throw DeviceFault (kNoContact, kWrongDevice) and Interrupted; those that say so also throw
// OscRefusal. Timeouts use the machine's clock, as sockets do: connect_timeout_ms to connect and
// for each part of a reply, twice that for a whole reply, and picture_timeout_ms for a picture.
class OscClient {
 public:
  // Throws UsageError for an address that is not "http://host" or "http://host:port".
  OscClient(const OscConfig& config, Clock& clock);
  ~OscClient();

  const std::string& url() const { return config_.url; }
  // A fault of this camera, whose message starts with its address and the path.
  DeviceFault fault(FaultKind kind, const std::string& what, const std::string& path = "") const;

  nlohmann::json info();   // of /osc/info: manufacturer, model, ...
  nlohmann::json state();  // the state object of /osc/state: batteryLevel, _captureStatus, ...
  // Level 1 of the API requires a session before any command; a Ricoh Theta S is switched to level
  // 2, as its documentation requires. Call it before each group of commands, because sessions
  // expire.
  void open_session();

  // Values of options by name, without those that the camera does not have.
  nlohmann::json options(const std::vector<std::string>& names);
  void set_options(const nlohmann::json& options);  // throws OscRefusal
  OscCommand begin_picture();                       // never repeated; throws OscRefusal
  OscCommand status_of(const std::string& id);      // throws OscRefusal
  std::string fetch(const std::string& file);

 private:
  enum class Repeat { kNever, kIfUnanswered };
  struct Reply;
  struct Answer;

  Reply send(const std::string& path, const std::string& body, bool for_picture);
  Reply ask(const std::string& path, const std::string& body, Repeat repeat, bool for_picture);
  nlohmann::json object_from(const std::string& path, const std::string& body, Repeat repeat);
  Answer answer_from(const std::string& path, const nlohmann::json& request, Repeat repeat);
  Answer execute(const std::string& name, nlohmann::json parameters,
                 Repeat repeat = Repeat::kIfUnanswered);

  OscConfig config_;
  Clock& clock_;
  std::unique_ptr<httplib::Client> http_;
  std::set<std::string> unknown_options_;
  bool level_known_ = false;
  bool needs_session_ = false;
  std::string session_id_;
};

}  // namespace raywalk::capture
