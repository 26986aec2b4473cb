#include "capture/run/good_order.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// What stopped the work is what the user has to see, also where the session cannot be written.
void note_event(Session* session, const std::string& kind, const std::string& text) {
  try {
    session->record_event(kind, text);
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
  }
}

}  // namespace

void in_good_order(Session* session, const WorkState& state, const std::function<void()>& work) {
  try {
    work();
  } catch (const Interrupted&) {
    note_event(session, "interrupted", state.place);
    throw Interrupted(
        fmt::format("interrupted at {}; the slider stands, {}; the same command goes on",
                    state.place, state.done()));
  } catch (const Error& error) {
    note_event(session, "paused", state.place + ": " + error.what());
    throw Paused(fmt::format("{}: {}. Paused with {}; the same command goes on afterwards",
                             state.place, error.what(), state.done()));
  }
}

}  // namespace raywalk::capture
