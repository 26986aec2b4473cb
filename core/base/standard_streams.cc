#include "core/base/standard_streams.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ext/stdio_sync_filebuf.h>
#include <iostream>
#include <new>
#include <utility>

#include "core/base/escaped.h"
#include "core/base/utf8.h"

namespace raywalk {
namespace {

using StdioBuffer = __gnu_cxx::stdio_sync_filebuf<char>;

thread_local std::string* captured_errors = nullptr;

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// A stream of the C library that escapes what is written to it (fopencookie(3)).
class EscapingStream {
 public:
  EscapingStream(int descriptor, int buffering) : descriptor_(descriptor) {
    cookie_io_functions_t functions{};
    functions.write = &EscapingStream::write_piece;
    file_ = fopencookie(this, "w", functions);
    if (file_ == nullptr) throw std::bad_alloc();
    setvbuf(file_, nullptr, buffering, BUFSIZ);
  }

  std::FILE* file() const { return file_; }

 private:
  // The C library calls it with the stream locked. Returns 0 on failure, with errno.
  static ssize_t write_piece(void* cookie, const char* bytes, std::size_t size) {
    auto* stream = static_cast<EscapingStream*>(cookie);
    if (stream->descriptor_ == STDERR_FILENO && captured_errors != nullptr) {
      captured_errors->append(bytes, size);
      return static_cast<ssize_t>(size);
    }
    const std::string text = std::move(stream->begun_).append(bytes, size);
    // A buffer may end within a character.
    constexpr std::size_t kLongestPart = 3;
    std::size_t keep = std::min(kLongestPart, text.size());
    while (keep > 0 && !is_part_of_utf8(std::string_view(text).substr(text.size() - keep))) --keep;
    const std::string_view all = text;
    stream->begun_ = all.substr(all.size() - keep);
    const std::string shown = escaped(all.substr(0, all.size() - keep), LineBreaks::kKeep);
    const bool written = write_all(stream->descriptor_, shown);
    return written ? static_cast<ssize_t>(size) : 0;
  }

  int descriptor_;
  std::FILE* file_ = nullptr;
  std::string begun_{};
};

// The streams are never closed: loggers keep them.
EscapingStream& escaping_stdout() {
  static auto* stream =
      new EscapingStream(STDOUT_FILENO, isatty(STDOUT_FILENO) == 1 ? _IOLBF : _IOFBF);
  return *stream;
}
EscapingStream& escaping_stderr() {
  static auto* stream = new EscapingStream(STDERR_FILENO, _IONBF);
  return *stream;
}

std::streambuf* buffer_of(const EscapingStream& stream) { return new StdioBuffer(stream.file()); }

void flush_all() {
  std::cout.flush();
  std::clog.flush();
  std::fflush(stdout);
  std::fflush(stderr);
}

}  // namespace

// The GNU C library lets programs set stdout and stderr (its manual, "Standard Streams").
EscapedStreams::EscapedStreams()
    : stdout_before_(stdout),
      stderr_before_(stderr),
      cout_before_(std::cout.rdbuf()),
      cerr_before_(std::cerr.rdbuf()),
      clog_before_(std::clog.rdbuf()) {
  flush_all();
  static std::streambuf* const to_stdout = buffer_of(escaping_stdout());
  static std::streambuf* const to_stderr = buffer_of(escaping_stderr());
  stdout = escaping_stdout().file();
  stderr = escaping_stderr().file();
  std::cout.rdbuf(to_stdout);
  std::cerr.rdbuf(to_stderr);
  std::clog.rdbuf(to_stderr);
}

EscapedStreams::~EscapedStreams() {
  flush_all();
  stdout = stdout_before_;
  stderr = stderr_before_;
  std::cout.rdbuf(cout_before_);
  std::cerr.rdbuf(cerr_before_);
  std::clog.rdbuf(clog_before_);
}

CapturedErrors::CapturedErrors() { captured_errors = &text_; }

CapturedErrors::~CapturedErrors() { captured_errors = nullptr; }

void print_to_terminal(std::string_view text) { static_cast<void>(write_all(STDERR_FILENO, text)); }

}  // namespace raywalk
