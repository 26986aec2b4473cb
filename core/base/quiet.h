// --quiet: nothing but warnings and errors.
#pragma once

namespace raywalk {

// Silences progress and information for as long as it lives. Not for several threads: it is made
// before the work starts.
class Quiet {
 public:
  // With `results`, standard output is silenced too.
  explicit Quiet(bool results);
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  int saved_stdout_ = -1;
};

// Whether progress is not to be shown.
bool is_quiet();

}  // namespace raywalk
