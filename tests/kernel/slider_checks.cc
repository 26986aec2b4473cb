#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "tests/kernel/check_report.h"

namespace raywalk::capture {
namespace {

// Starting a slave includes loading Python's libraries, possibly on a busy machine.
constexpr int kTimeout_ms = 60000;

// Connection to serial_host.py, which corrupts, cuts and unplugs the serial links on request.
class HostChannel {
 public:
  // Throws CheckFailure if the port cannot be opened.
  explicit HostChannel(const std::string& device)
      : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    require(fd_ >= 0, "cannot open " + device);
    termios settings{};
    tcgetattr(fd_, &settings);
    cfmakeraw(&settings);
    tcsetattr(fd_, TCSANOW, &settings);
  }
  ~HostChannel() { close(fd_); }
  HostChannel(const HostChannel&) = delete;
  HostChannel& operator=(const HostChannel&) = delete;

  // Sends an order (see serial_host.py) and waits until it is done; returns the number in the
  // reply. Throws CheckFailure if the order fails or there is no reply.
  int ask(const std::string& order) {
    const std::string line = order + "\n";
    require(write(fd_, line.data(), line.size()) == static_cast<ssize_t>(line.size()),
            "cannot write to the host's port");
    const std::string answer = read_line();
    require(answer.starts_with("done "), "the host failed to execute '" + order + "': " + answer);
    return std::stoi(answer.substr(5));
  }

 private:
  std::string read_line() {
    std::string line;
    for (;;) {
      pollfd input{.fd = fd_, .events = POLLIN, .revents = 0};
      require(poll(&input, 1, kTimeout_ms) > 0, "no reply from the host");
      char letter = 0;
      require(read(fd_, &letter, 1) == 1, "the host's port was closed");
      if (letter == '\n') return line;
      line += letter;
    }
  }

  int fd_;
};

const std::string kSerialPort = "/dev/ttyS1";
const std::string kOrders = "/dev/ttyS2";
const std::string kUsbAdapter = "/dev/slider";
const SoftLimits kLimits(0.0, 1000.0);
constexpr double kNear_mm = 0.02;

SliderConfig config_at(const std::string& device) {
  SliderConfig config;
  config.device = device;
  config.tries = 4;
  config.response_timeout_ms = 300.0;
  config.byte_timeout_ms = 200.0;
  config.register_map = RAYWALK_CONFIGS "/sliders/generic.yaml";
  return config;
}

MotionRules rules() {
  MotionRules rules;
  rules.profile = {200.0, 2000.0};
  rules.settle_ms = 100.0;
  rules.stall_ms = 5000.0;  // the virtual machine may be slow
  return rules;
}

// A slider session of one program, from opening to closing the port.
struct Rig {
  explicit Rig(const std::string& device) : slider(open_slider(config_at(device), &clock)) {}

  void move(double target_mm) {
    const SettledPosition settled = carriage.move_to(kLimits.require(target_mm, "check"));
    require_near(settled.measured_mm, target_mm, kNear_mm, "settled position");
    require_near(slider->read_state().position_mm, target_mm, kNear_mm, "position afterwards");
  }
  // Moves and sends an order to the host halfway.
  void move_with(HostChannel* host, const std::string& order, double target_mm) {
    const double halfway_mm = (slider->read_state().position_mm + target_mm) / 2.0;
    bool asked = false;
    carriage.watch([&, halfway_mm](WallTime /*time*/, double position_mm) {
      if (asked || position_mm < halfway_mm) return;
      asked = true;
      host->ask(order);
    });
    try {
      move(target_mm);
    } catch (...) {
      carriage.watch({});
      throw;
    }
    carriage.watch({});
    require(asked, "the move ended before its middle was observed");
  }

  SystemClock clock;
  std::unique_ptr<ModbusSlider> slider;
  Carriage carriage{slider.get(), &clock, kLimits, rules()};
};

void home_and_move(Rig* rig) {
  require(rig->slider->read_state().homed == false, "claims to be homed from the start");
  rig->carriage.home();
  require(rig->slider->read_state().homed == true, "not homed");
  for (const double target_mm : {150.0, 12.34, 12.5}) rig->move(target_mm);
}

void check_moves() {
  Rig rig(kSerialPort);
  home_and_move(&rig);
}

void check_port_lock() {
  Rig owner(kSerialPort);
  owner.slider->read_state();
  Rig other(kSerialPort);
  require_fault(FaultKind::kNoContact, "in use by another program",
                [&] { other.slider->read_state(); });
}

// Moves while one in a few replies has a fault; the host counts the faults.
void check_faulty_line(HostChannel* host, const std::string& fault) {
  Rig rig(kSerialPort);
  rig.move(20.0);
  host->ask("serial " + fault);
  rig.move(120.0);
  require(host->ask("serial heal") > 0, "no reply had a fault");
  require_near(rig.slider->read_state().position_mm, 120.0, kNear_mm, "position afterwards");
}

void check_useless_line(HostChannel* host) {
  Rig rig(kSerialPort);
  host->ask("serial corrupt 1");
  require_fault(FaultKind::kNoContact, "Invalid CRC", [&] { rig.slider->read_state(); });
  host->ask("serial heal");
  rig.move(20.0);
}

// Contact is lost during a move: stops are sent, and the message says that none was confirmed.
void require_lost(HostChannel* host, Rig* rig, const std::string& order) {
  require_fault(FaultKind::kNoContact, "NOT known to have stopped",
                [&] { rig->move_with(host, order, 900.0); });
}

void check_cut_cable(HostChannel* host) {
  Rig rig(kSerialPort);
  rig.move(20.0);
  const int stops_before = host->ask("serial stops");
  require_lost(host, &rig, "serial cut");
  require(host->ask("serial stops") > stops_before, "no stop was sent over the cut cable");
  host->ask("serial heal");
  rig.carriage.stop();
  require(rig.slider->read_state().moving == false, "still moving after a confirmed stop");
  rig.move(30.0);
}

void check_killed_drive(HostChannel* host) {
  Rig rig(kSerialPort);
  rig.move(20.0);
  require_lost(host, &rig, "serial kill");
  host->ask("serial start");
  require_fault(FaultKind::kAlarm, "home first", [&] { rig.move(30.0); });
  rig.carriage.home();
  rig.move(30.0);
}

void wait_for_adapter(Clock* clock) {
  const SteadyTime deadline = clock->now() + std::chrono::seconds(30);
  while (!std::filesystem::exists(kUsbAdapter)) {
    require(clock->now() < deadline, "the adapter does not reappear");
    clock->sleep(std::chrono::milliseconds(50));
  }
}

void check_usb(HostChannel* host) {
  Rig rig(kUsbAdapter);
  require_fault(FaultKind::kNoContact, "plug in the adapter", [&] { rig.slider->read_state(); });
  host->ask("usb plug");
  wait_for_adapter(&rig.clock);
  home_and_move(&rig);
}

void check_usb_brief_unplug(HostChannel* host) {
  Rig rig(kUsbAdapter);
  rig.move(20.0);
  rig.move_with(host, "usb replug", 220.0);
}

void check_usb_unplug(HostChannel* host) {
  Rig rig(kUsbAdapter);
  rig.move(20.0);
  require_lost(host, &rig, "usb unplug");
  require_fault(FaultKind::kNoContact, "plug in the adapter", [&] { rig.slider->read_state(); });
  host->ask("usb plug");
  wait_for_adapter(&rig.clock);
  rig.carriage.stop();
  rig.move(30.0);
}

}  // namespace

void check_slider(CheckReport* report) {
  HostChannel host(kOrders);
  // A failed check may have left the link with a fault.
  const auto run = [&](const std::string& name, const std::function<void()>& check) {
    report->run(name, [&] {
      host.ask("serial heal");
      check();
    });
  };
  run("serial: homes, moves, reads back", check_moves);
  run("serial: port held by another program", check_port_lock);
  for (const std::string fault :
       {"corrupt 3", "truncate 3", "lose 3", "double 2", "noise 3", "delay 7"}) {
    run("serial: moves with faulty replies: " + fault, [&] { check_faulty_line(&host, fault); });
  }
  run("serial: all replies corrupted", [&] { check_useless_line(&host); });
  run("serial: cable cut during a move", [&] { check_cut_cable(&host); });
  run("serial: drive loses power during a move", [&] { check_killed_drive(&host); });
  run("usb: adapter plugged in, homes, moves", [&] { check_usb(&host); });
  run("usb: adapter replugged during a move", [&] { check_usb_brief_unplug(&host); });
  run("usb: adapter unplugged during a move, plugged in later", [&] { check_usb_unplug(&host); });
}

}  // namespace raywalk::capture
