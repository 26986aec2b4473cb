// Replies of the simulated camera to requests of the Open Spherical Camera API, level 2.
//
// Sources: developers.google.com/streetview/open-spherical-camera; options, states, error codes and
// their HTTP status from the Ricoh Theta Web API v2.1 (github.com/ricohapi/theta-api-specs).
#pragma once

#include <string>

#include "simulator/rig/simulated_camera.h"

namespace raywalk::capture {

struct OscReply {
  int http_status = 200;
  std::string json;
};

// Thread-safe. `base_url` is the address of the camera's files: "http://127.0.0.1:8080".
class OscApi {
 public:
  explicit OscApi(SimulatedCamera& camera) : camera_(camera) {}

  OscReply info() const;                                                        // GET /osc/info
  OscReply state(const std::string& base_url) const;                            // POST /osc/state
  OscReply execute(const std::string& body, const std::string& base_url);       // .../execute
  OscReply status(const std::string& body, const std::string& base_url) const;  // .../status

 private:
  SimulatedCamera& camera_;
};

}  // namespace raywalk::capture
