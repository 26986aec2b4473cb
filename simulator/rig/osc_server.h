// HTTP server of the simulated camera on loopback.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "simulator/rig/faults.h"
#include "simulator/rig/simulated_camera.h"

namespace httplib {
class Server;
struct Response;
}  // namespace httplib

namespace raywalk::simulator {

// Serves /osc/info, /osc/state, /osc/commands/execute, /osc/commands/status and /files/NAME from
// construction to destruction, and applies the faults of requests. Every client has a thread of its
// own, so that none waits for another.
class OscServer {
 public:
  // Takes the body of a request and returns the JSON text of the reply. An Error becomes HTTP 400
  // with {"error": {"message": ...}}.
  using Handler = std::function<std::string(const std::string& body)>;

  // Camera and faults must outlive the server. Binds the port on 127.0.0.1; 0 chooses a free one.
  // `more` are further endpoints, by their paths, for GET and POST; the faults of requests do not
  // apply to them. Throws Error if the port is in use.
  OscServer(SimulatedCamera* camera, Faults* faults, int port,
            const std::map<std::string, Handler>& more = {});
  // Aborts waiting requests and closes the port.
  ~OscServer();
  OscServer(const OscServer&) = delete;
  OscServer& operator=(const OscServer&) = delete;

  int port() const { return port_; }
  std::string url() const;  // "http://127.0.0.1:PORT"

 private:
  void add_camera();
  void answer(const std::function<OscReply()>& reply, httplib::Response* response);
  void send_file(const std::string& name, httplib::Response* response);
  bool stays_silent();

  SimulatedCamera* camera_;
  Faults* faults_;
  std::unique_ptr<httplib::Server> server_;
  int port_ = 0;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace raywalk::simulator
