#include "simulator/rig/drive_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <string>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Leadshine's: one block starts a move with its last word; home and stop share a register.
const RegisterMap kLeadshine = read_register_map(RAYWALK_CONFIGS "/sliders/leadshine-pr0.yaml");

struct ModbusDeleter {
  void operator()(modbus_t* link) const {
    modbus_close(link);
    modbus_free(link);
  }
};
using Client = std::unique_ptr<modbus_t, ModbusDeleter>;

class DriveServerTest : public ::testing::Test {
 protected:
  static DriveSettings exact() {
    DriveSettings settings;
    settings.backlash_mm = 0.0;
    settings.power_on_mm = 0.0;
    return settings;
  }
  fs::path link() const { return directory_ / "slider"; }
  static Client prepared(modbus_t* link) {
    modbus_set_slave(link, 1);
    modbus_set_response_timeout(link, 20, 0);
    return Client(link);
  }
  // For a request that is not answered.
  static void use_short_timeouts(const Client& client) {
    modbus_set_response_timeout(client.get(), 0, 60000);
    modbus_set_byte_timeout(client.get(), 0, 60000);
  }
  Client serial_client() const {
    Client client = prepared(modbus_new_rtu(link().c_str(), 115200, 'N', 8, 1));
    EXPECT_EQ(modbus_connect(client.get()), 0) << modbus_strerror(errno);
    return client;
  }
  Client tcp_client() const {
    Client client = prepared(modbus_new_tcp("127.0.0.1", server_.tcp_port()));
    EXPECT_EQ(modbus_connect(client.get()), 0) << modbus_strerror(errno);
    return client;
  }
  // The position's words, or the error's number.
  static std::string read_position(modbus_t* client) {
    std::array<std::uint16_t, 2> words{};
    if (modbus_read_registers(client, 0x1014, 2, words.data()) != 2) return modbus_strerror(errno);
    return std::to_string(words[0] * 65536 + words[1]);
  }
  template <typename Condition>
  static bool eventually(const Condition& condition) {
    const auto deadline = Steady::now() + std::chrono::seconds(20);
    while (!condition()) {
      if (Steady::now() > deadline) return false;
      poll(nullptr, 0, 2);
    }
    return true;
  }

  const TestDirectory directory_;
  ManualClock clock_;
  Faults faults_{&clock_, {.late_ms = 400.0}};
  SimulatedDrive drive_{exact(), &clock_, &faults_};
  DriveServer server_{{1, directory_ / "slider", 0}, kLeadshine, &drive_, &faults_};
};

// A killed client that held the port exclusively must not lock out the next one.
TEST_F(DriveServerTest, ExclusiveUseEndsWithTheClient) {
  const int terminal = open(link().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(ioctl(terminal, TIOCEXCL), 0);
  const auto is_exclusive = [terminal] {
    int exclusive = 1;
    ioctl(terminal, TIOCGEXCL, &exclusive);
    return exclusive != 0;
  };
  EXPECT_TRUE(eventually([&] { return !is_exclusive(); }));
  close(terminal);
}

TEST_F(DriveServerTest, BroadcastsAreExecutedAndOtherUnitsIgnored) {
  const int terminal = open(link().c_str(), O_RDWR | O_NOCTTY);
  // To unit 0; the last two bytes are the checksum.
  const std::array<std::uint8_t, 8> home{0, 6, 0x60, 0x02, 0, 0x20, 0x36, 0x03};
  ASSERT_EQ(write(terminal, home.data(), home.size()), static_cast<ssize_t>(home.size()));
  EXPECT_TRUE(eventually([&] {
    clock_.sleep(milliseconds(100));
    return drive_.state().homed;
  }));
  close(terminal);
  const Client client = serial_client();
  use_short_timeouts(client);
  modbus_set_slave(client.get(), 2);
  EXPECT_EQ(read_position(client.get()), modbus_strerror(ETIMEDOUT));
  EXPECT_EQ(faults_.exchanges(), 1U);
}

TEST_F(DriveServerTest, ExceptionsReachTheClient) {
  const Client client = tcp_client();
  std::array<std::uint16_t, 2> words{};
  EXPECT_EQ(modbus_read_input_registers(client.get(), 0x1014, 2, words.data()), -1);
  EXPECT_EQ(errno, EMBXILADD);
  // A move at speed 0, to a position that is not that of the drive.
  const std::array<std::uint16_t, 8> block{1, 0, 1, 0, 5000, 5000, 0, 0x10};
  EXPECT_EQ(modbus_write_registers(client.get(), 0x6200, 8, block.data()), -1);
  EXPECT_EQ(errno, EMBXILVAL);
  EXPECT_EQ(drive_.truth().moves, 0);
}

TEST_F(DriveServerTest, WriteWithoutTheTriggerIsStoredWithoutMoving) {
  const Client client = tcp_client();
  const std::array<std::uint16_t, 8> block{1, 0, 7000, 150, 5000, 5000, 0, 0};
  EXPECT_EQ(modbus_write_registers(client.get(), 0x6200, 8, block.data()), 8);
  EXPECT_EQ(modbus_write_register(client.get(), 0x6200, 1), 1);
  EXPECT_EQ(drive_.truth().moves, 0);
  std::uint16_t word = 0;
  EXPECT_EQ(modbus_read_registers(client.get(), 0x6202, 1, &word), 1);
  EXPECT_EQ(word, 7000);
}

// As on a real line, the late reply is mistaken for the reply to the next request.
TEST_F(DriveServerTest, LateReplyArrivesAfterTheTimeout) {
  const Client client = serial_client();
  use_short_timeouts(client);
  faults_.add({.kind = RigFault::kLate});
  EXPECT_EQ(read_position(client.get()), modbus_strerror(ETIMEDOUT));
  std::uint8_t byte = 0;
  pollfd descriptor{modbus_get_socket(client.get()), POLLIN, 0};
  ASSERT_EQ(poll(&descriptor, 1, 20000), 1);
  ASSERT_EQ(read(descriptor.fd, &byte, 1), 1);
  EXPECT_EQ(byte, 1);
}

TEST_F(DriveServerTest, MisbehavingClientsDoNotAffectOthers) {
  const Client good = tcp_client();
  {
    const Client rude = tcp_client();
    const std::string http = "GET / HTTP/1.1\r\n\r\n";
    ASSERT_GT(write(modbus_get_socket(rude.get()), http.data(), http.size()), 0);
    pollfd descriptor{modbus_get_socket(rude.get()), POLLIN, 0};
    EXPECT_EQ(poll(&descriptor, 1, 20000), 1);  // is closed
    std::uint8_t byte = 0;
    EXPECT_LE(read(descriptor.fd, &byte, 1), 0);
  }
  const int terminal = open(link().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GT(write(terminal, "\x01\x03\x10", 3), 0);  // half a request
  close(terminal);
  poll(nullptr, 0, 30);
  EXPECT_EQ(read_position(good.get()), "0");
  EXPECT_EQ(read_position(serial_client().get()), "0");
}

TEST_F(DriveServerTest, PortOrNameInUseIsAnError) {
  for (const DriveServerSettings& settings :
       {DriveServerSettings{1, {}, server_.tcp_port()},
        DriveServerSettings{1, directory_.path(), {}},
        DriveServerSettings{1, directory_ / "no/slider", {}}}) {
    EXPECT_THROW(DriveServer(settings, kLeadshine, &drive_, &faults_), Error);
  }
}

}  // namespace
}  // namespace raywalk::simulator
