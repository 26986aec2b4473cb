// Renders the views that clients ask for, one at a time.
#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <mutex>

#include "core/room/room.h"
#include "render/serve/view_request.h"
#include "render/serve/web_server.h"

namespace raywalk::render {

inline constexpr int kMostWaitingViews = 4;

class ViewService {
 public:
  // The room must outlive the service.
  explicit ViewService(const Room& room);
  ~ViewService();

  // The picture, as `raywalk-render view` renders it with the same parameters; the field
  // X-Raywalk-View says how. Called on several threads. Throws HttpFault: 400 where the room or the
  // limits do not allow what is asked for, 422 where the viewpoint cannot be rendered, 503 with too
  // many requests, Interrupted after Ctrl-C.
  Reply answer(const ViewRequest& request);

  // Refuses the requests that wait; the view being rendered is finished.
  void stop() { stopped_ = true; }

 private:
  struct Prepared;

  Prepared& prepared_for(const ViewRequest& request);

  const Room& room_;
  std::atomic<bool> stopped_ = false;
  std::atomic<int> inside_ = 0;                    // requests that wait or are answered
  std::mutex turn_;                                // of the request that renders
  std::list<std::unique_ptr<Prepared>> prepared_;  // last used first; of who has the turn
};

}  // namespace raywalk::render
