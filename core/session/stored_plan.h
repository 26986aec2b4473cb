// The plan that a session stores as JSON when it is created, compared with its tables. A step of
// read_session_contents (session_contents.h).
#pragma once

#include <string>

#include "core/session/session_contents.h"

namespace raywalk {

// Throws Error, as throw_damaged_session does, where lines, stations, exposures or the kind of
// frames are not those of the plan.
void require_stored_plan(const SessionContents& contents, const std::string& plan_json);

}  // namespace raywalk
