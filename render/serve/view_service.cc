#include "render/serve/view_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/view/renderer.h"
#include "core/view/view_height.h"
#include "core/view/view_mode.h"
#include "render/view/view_file.h"
#include "render/view/view_frame.h"
#include "render/view/view_settings.h"

namespace raywalk::render {
namespace {

// Renderers that are kept: of the three methods, and one more that somebody compares with.
constexpr std::size_t kMostPrepared = 4;
constexpr int kJpegQuality = 95;
constexpr const char* kRetryAfter_s = "1";

ViewMethod method_of(const ViewRequest& request, const Room& room) {
  const ViewMethod best = room.has_distances() ? ViewMethod::kTwoSided : ViewMethod::kInitial;
  const ViewMethod chosen = request.method.value_or(best);
  if (chosen != ViewMethod::kInitial && !room.has_distances()) {
    throw HttpFault(400, fmt::format("method {} needs distances, which the room does not have",
                                     method_name(chosen)));
  }
  return chosen;
}

ViewSettings settings_of(const ViewRequest& request, const Room& room) {
  ViewSettings settings;
  settings.options.method = method_of(request, room);
  if (request.k_deg) settings.options.k_deg = *request.k_deg;
  settings.options.width = request.panorama_width_px;
  if (request.frame.fov_deg == 0.0 && request.panorama_width_px == 0) {
    settings.options.width = std::min(size_as_captured(room).width, kMostServedSide_px);
  }
  return settings;
}

Viewpoint viewpoint_of(const ViewRequest& request, const Room& room) {
  if (request.up_m == 0.0) return request.viewpoint;
  return {request.viewpoint, height_around(room.grid(), request.viewpoint) + request.up_m};
}

Reply picture_reply(const cv::Mat& picture, bool png) {
  std::vector<unsigned char> bytes;
  if (png) {
    cv::imencode(".png", picture, bytes);
  } else {
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  }
  return {.type = png ? "image/png" : "image/jpeg",
          .body = std::string(bytes.begin(), bytes.end()),
          .fields = {{"Cache-Control", "no-store"}}};
}

// Counts those that are inside.
class Counted {
 public:
  explicit Counted(std::atomic<int>* inside) : inside_(inside) { ++*inside_; }
  ~Counted() { --*inside_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::atomic<int>* inside_;
};

}  // namespace

struct ViewService::Prepared {
  Prepared(const Room& room, const ViewSettings& asked)
      : settings(asked), mode(view_mode(asked)), renderer(room, mode.options) {}

  ViewSettings settings;
  ViewMode mode;
  Renderer renderer;
};

ViewService::ViewService(const Room& room) : room_(room) {}
ViewService::~ViewService() = default;

Reply ViewService::answer(const ViewRequest& request) {
  const Counted inside(&inside_);
  if (stopped_ || inside_ > 1 + kMostWaitingViews) {
    Reply reply = refusal(HttpFault(503, "too many views are being rendered; try again soon"));
    reply.fields.emplace_back("Retry-After", kRetryAfter_s);
    return reply;
  }
  const std::lock_guard turn(turn_);
  if (stopped_) throw HttpFault(503, "the server is stopping");
  try {
    Prepared& prepared = prepared_for(request);
    const RenderedView view =
        render_framed(&prepared.renderer, viewpoint_of(request, room_), request.frame);
    Reply reply = picture_reply(view.image, request.png);
    reply.fields.emplace_back("X-Raywalk-View", view_summary(prepared.mode, view.report));
    return reply;
  } catch (const HttpFault&) {
    throw;
  } catch (const UsageError& error) {
    throw HttpFault(400, error.what());
  } catch (const Error& error) {
    throw HttpFault(422, error.what());
  }
}

ViewService::Prepared& ViewService::prepared_for(const ViewRequest& request) {
  const ViewSettings settings = settings_of(request, room_);
  const auto found = std::find_if(prepared_.begin(), prepared_.end(), [&](const auto& prepared) {
    return prepared->settings == settings;
  });
  if (found != prepared_.end()) {
    prepared_.splice(prepared_.begin(), prepared_, found);
  } else {
    if (prepared_.size() == kMostPrepared) prepared_.pop_back();
    prepared_.push_front(std::make_unique<Prepared>(room_, settings));
  }
  return *prepared_.front();
}

}  // namespace raywalk::render
