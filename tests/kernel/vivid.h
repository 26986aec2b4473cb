// Controls the scene and connection of vivid's simulated camera.
#pragma once

#include <cstdint>
#include <string>

namespace raywalk::capture {

constexpr int kWebcamInput = 0;  // a few fixed sizes
constexpr int kHdmiInput = 1;    // any size, cropped from 1920x1080

// Values of its control "Test Pattern" (Documentation/admin-guide/media/vivid.rst).
enum class VividScene { kBlack = 5, kWhite = 6, kRed = 7, kGreen = 8, kBlue = 9 };

// A second user of the device, independent of the checked code. Methods throw CheckFailure.
class Vivid {
 public:
  explicit Vivid(const std::string& device);
  ~Vivid();
  Vivid(const Vivid&) = delete;
  Vivid& operator=(const Vivid&) = delete;

  void select_input(int input);  // not while streaming
  // A uniform colour, from the start of the next frame.
  void show(VividScene scene);
  // Simulates a change by another program.
  void change_gain();
  // Simulates unplugging; the device returns when its last user has closed it.
  void disconnect();

 private:
  void set_control(std::uint32_t id, int value);

  int fd_;
};

}  // namespace raywalk::capture
