// The rig's camera on the network: an HTTP server on loopback that speaks the Open Spherical Camera
// API, level 2 (developers.google.com/streetview/open-spherical-camera), with the options and error
// codes of the Ricoh Theta Web API v2.1.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "capture/simulated/rig/simulated_camera.h"

namespace raywalk::capture {

// Answers /osc/info, /osc/state, /osc/commands/execute (getOptions, setOptions, takePicture,
// listFiles, delete), /osc/commands/status and /files/NAME from start() to stop(), several requests
// at once, and does to them what the camera's faults say.
class OscServer {
 public:
  // A request's body in, the JSON text of the answer out. An Error becomes HTTP 400 with
  // {"error": {"message": ...}}.
  using Handler = std::function<std::string(const std::string& body)>;

  // The camera must outlive the server. Binds 127.0.0.1 at once; port 0 takes a free one. Throws
  // Error if the port is taken.
  OscServer(SimulatedCamera& camera, int port);
  ~OscServer();
  OscServer(const OscServer&) = delete;
  OscServer& operator=(const OscServer&) = delete;

  // Other things to answer, beside the camera; before start(). Only the fault kDown concerns them.
  void on_get(const std::string& path, Handler handler);
  void on_post(const std::string& path, Handler handler);

  void start();
  // Ends requests that are kept waiting. The port stays bound to nobody; start() takes it again.
  void stop();

  int port() const;
  std::string url() const;  // "http://127.0.0.1:PORT"

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raywalk::capture
