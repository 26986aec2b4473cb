// Replies with content that browsers keep: whole, a part of it, or not at all where the client has
// it.
#pragma once

#include <filesystem>
#include <string>

#include "render/serve/web_server.h"

namespace raywalk::render {

// The content of a file now. Browsers ask every time whether it has changed, by its ETag: another
// room may be served at the same address the next time. Throws HttpFault 404 where it is no regular
// file (any more).
Reply file_reply(const std::filesystem::path& file, const std::string& type,
                 const Request& request);

// The same of a text that is served as a file.
Reply text_reply(std::string text, const std::string& type, const Request& request);

}  // namespace raywalk::render
