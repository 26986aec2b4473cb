// The scene in front of vivid's camera, and its cable.
#pragma once

#include <cstdint>
#include <string>

namespace raywalk::capture {

constexpr int kWebcamInput = 0;  // a few fixed sizes
constexpr int kHdmiInput = 1;    // any size, cut out of 1920x1080

// Values of its control "Test Pattern" (Documentation/admin-guide/media/vivid.rst).
enum class VividScene { kBlack = 5, kWhite = 6, kRed = 7, kGreen = 8, kBlue = 9 };

// A second user of the device beside the one that is checked. Calls throw CheckFailure.
class Vivid {
 public:
  explicit Vivid(const std::string& device);
  ~Vivid();
  Vivid(const Vivid&) = delete;
  Vivid& operator=(const Vivid&) = delete;

  void select_input(int input);  // while nobody streams
  // One colour all over, from the next frame that is begun.
  void show(VividScene scene);
  // As another program might.
  void change_gain();
  // Until the last user has closed the device, it is gone for all.
  void disconnect();

 private:
  void set_control(std::uint32_t id, int value);

  int fd_;
};

}  // namespace raywalk::capture
