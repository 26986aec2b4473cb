// Replies with the content of files: whole, in parts, or not at all where the client has it.
#pragma once

#include <string>

#include "core/http/reply.h"
#include "core/http/request_head.h"
#include "render/serve/served_files.h"

namespace raywalk::render {

// A file's content now. Browsers keep it and ask every time whether it has changed (ETag with
// If-None-Match): another room may be served at the same address the next time. Range and If-Range
// are obeyed as RFC 9110 (14) says, several parts as multipart/byteranges. Throws HttpFault 404
// where the file is gone or a link now, 500 where it cannot be read.
Reply file_reply(const ServedFile& file, const RequestHead& head);

// The same of a text that is served as a file.
Reply text_reply(const std::string& text, const std::string& type, const RequestHead& head);

}  // namespace raywalk::render
