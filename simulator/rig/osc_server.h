// HTTP server of the simulated camera on loopback: the Open Spherical Camera API, level 2
// (developers.google.com/streetview/open-spherical-camera), with the options and error codes of the
// Ricoh Theta Web API v2.1.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "simulator/rig/simulated_camera.h"

namespace raywalk::capture {

// Serves /osc/info, /osc/state, /osc/commands/execute (getOptions, setOptions, takePicture,
// listFiles, delete), /osc/commands/status and /files/NAME from start() to stop(), and applies the
// camera's faults. Every client has a thread of its own, so that none waits for another.
class OscServer {
 public:
  // Takes the body of a request and returns the JSON text of the reply. An Error becomes HTTP 400
  // with {"error": {"message": ...}}.
  using Handler = std::function<std::string(const std::string& body)>;

  // The camera must outlive the server. Binds the port on 127.0.0.1 immediately; 0 chooses a free
  // one. Throws Error if the port is in use.
  OscServer(SimulatedCamera& camera, int port);
  ~OscServer();
  OscServer(const OscServer&) = delete;
  OscServer& operator=(const OscServer&) = delete;

  // Adds further endpoints; call before start(). Of the faults, only kDown applies to them.
  void on_get(const std::string& path, Handler handler);
  void on_post(const std::string& path, Handler handler);

  void start();
  // Aborts waiting requests and closes the port; start() binds the same port again.
  void stop();

  int port() const;
  std::string url() const;  // "http://127.0.0.1:PORT"

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raywalk::capture
