// What a program prints on stdout and stderr.
#pragma once

#include <cstdio>
#include <iosfwd>
#include <string>
#include <string_view>

namespace raywalk {

// During its lifetime all that is printed through std::cout, std::cerr, std::clog, `stdout` and
// `stderr`, also by libraries, is shown as escaped(text, LineBreaks::kKeep) (escaped.h): no name of
// a file can act on the terminal, whoever prints it. One at a time, made and destroyed while no
// other thread prints.
class EscapedStreams {
 public:
  EscapedStreams();
  ~EscapedStreams();
  EscapedStreams(const EscapedStreams&) = delete;
  EscapedStreams& operator=(const EscapedStreams&) = delete;

 private:
  std::FILE* stdout_before_;
  std::FILE* stderr_before_;
  std::streambuf* cout_before_;
  std::streambuf* cerr_before_;
  std::streambuf* clog_before_;
};

// Keeps what this thread prints on stderr within EscapedStreams, instead of showing it: libraries
// that decode files print what they find there, without the file's name. Not nested.
class CapturedErrors {
 public:
  CapturedErrors();
  ~CapturedErrors();
  CapturedErrors(const CapturedErrors&) = delete;
  CapturedErrors& operator=(const CapturedErrors&) = delete;

  const std::string& text() const { return text_; }

 private:
  std::string text_{};
};

// Prints to stderr as it is, with the controls of a live line.
void print_to_terminal(std::string_view text);

}  // namespace raywalk
