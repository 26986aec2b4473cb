// Renders the views that clients ask for, one at a time.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/http/reply.h"
#include "core/room/room.h"
#include "core/view/view_mode.h"
#include "render/serve/view_request.h"

namespace raywalk::render {

inline constexpr int kMostWaitingViews = 4;

// A view uses all threads, so that several at a time would all be late: requests take turns in the
// order they came.
class Turns {
 public:
  explicit Turns(int most_waiting) : most_waiting_(most_waiting) {}

  // Waits for its turn, which ends with it. Throws HttpFault 503 where too many wait, or after
  // stop().
  class Turn {
   public:
    explicit Turn(Turns& turns);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
  };

  // Refuses those who wait and all that come.
  void stop();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<const Turn*> line_;  // the first one has its turn
  int most_waiting_;
  bool stopped_ = false;
};

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
  void stop() { turns_.stop(); }

 private:
  struct Prepared;

  Prepared& prepared_for(const ViewRequest& request);

  const Room& room_;
  Turns turns_;
  std::list<std::unique_ptr<Prepared>> prepared_;  // last used first; of who has the turn
};

}  // namespace raywalk::render
