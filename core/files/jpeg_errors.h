// How libjpeg reports errors: to be used wherever it is called.
#pragma once

#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>

// jpeglib.h needs size_t and FILE declared before it.
#include <jpeglib.h>

namespace raywalk {

// libjpeg reports errors by calling error_exit, which must not return. Exceptions cannot pass its C
// frames, so longjmp is used as described in libjpeg.txt ("Error handling"): call setjmp(start)
// before libjpeg; no object that longjmp skips may have a destructor.
struct JpegErrorTrap {
  jpeg_error_mgr manager;  // first: libjpeg hands back a pointer to it
  std::jmp_buf start;
  std::array<char, JMSG_LENGTH_MAX> message;
};

// Keeps libjpeg's message and jumps to trap->start.
[[noreturn]] inline void leave_libjpeg(j_common_ptr info) {
  auto* trap = reinterpret_cast<JpegErrorTrap*>(info->err);
  info->err->format_message(info, trap->message.data());
  std::longjmp(trap->start, 1);
}

// The value for jpeg_compress_struct::err and jpeg_decompress_struct::err.
inline jpeg_error_mgr* prepare(JpegErrorTrap* trap) {
  jpeg_std_error(&trap->manager);
  trap->manager.error_exit = leave_libjpeg;
  return &trap->manager;
}

}  // namespace raywalk
