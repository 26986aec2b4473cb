#include "capture/run/pause_on_error.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// The user must see the original error, even if the session cannot be written.
void record_event(Session* session, const std::string& kind, const std::string& text) {
  try {
    session->record_event(kind, text);
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
  }
}

}  // namespace

void pause_on_error(Session* session, const WorkState& state, const std::function<void()>& work) {
  try {
    work();
  } catch (const Interrupted&) {
    record_event(session, "interrupted", state.place);
    throw Interrupted(
        fmt::format("interrupted at {}; the slider is at rest, {}; the same command resumes",
                    state.place, state.done()));
  } catch (const Error& error) {
    record_event(session, "paused", state.place + ": " + error.what());
    throw Paused(fmt::format("{}: {}. Paused with {}; the same command resumes", state.place,
                             error.what(), state.done()));
  }
}

}  // namespace raywalk::capture
