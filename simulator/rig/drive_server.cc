#include "simulator/rig/drive_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;

constexpr int kLongestWait_ms = 20;  // until it is asked whether the link is cut or the server ends
// Longer than the specified 3.5 characters at any common baud rate (4 ms at 9600), and than the
// pauses within one write on a busy machine.
constexpr int kSilence_ms = 10;
constexpr std::uint32_t kByteTimeout_us = 100'000;  // between the bytes of a request

std::string reason() { return std::generic_category().message(errno); }

void pause(int ms) { poll(nullptr, 0, ms); }

// After a damaged request the rest of it is dropped: a new one begins after a pause.
void drop_until_silence(int line) {
  std::array<std::uint8_t, 256> dropped{};
  pollfd waiting{line, POLLIN, 0};
  while (poll(&waiting, 1, kSilence_ms) > 0 && read(line, dropped.data(), dropped.size()) > 0) {
  }
}

// A client that has gone must not end the program by a signal.
void send_bytes(int line, const std::vector<std::uint8_t>& bytes) {
  if (send(line, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0 && errno == ENOTSOCK) {
    if (write(line, bytes.data(), bytes.size()) < 0) spdlog::debug("a reply is lost: {}", reason());
  }
}

}  // namespace

// The master side of a pseudo-terminal; clients open the other side through a symbolic link. The
// slave side is also held open here, so that clients may close and reopen it: otherwise the master
// would read EIO while no client is connected.
class DriveServer::Terminal {
 public:
  explicit Terminal(fs::path link) : link_(std::move(link)) {
    if (openpty(&master_, &slave_, nullptr, nullptr, nullptr) != 0) {
      throw Error("cannot create a pseudo-terminal: " + reason());
    }
    termios settings{};
    tcgetattr(slave_, &settings);
    cfmakeraw(&settings);
    tcsetattr(slave_, TCSANOW, &settings);
    // Bytes that do not fit its buffer are lost, as on a serial line.
    fcntl(master_, F_SETFL, O_NONBLOCK);
    name_ = ptsname(master_);
    std::error_code error;
    if (fs::is_symlink(link_)) fs::remove(link_, error);
    fs::create_symlink(name_, link_, error);
    if (!error) return;
    close_sides();
    throw Error(fmt::format("cannot create the link {}: {}", link_.string(), error.message()));
  }
  // Hangs up, so that the client reads end of file or EIO.
  ~Terminal() {
    std::error_code ignored;
    if (fs::read_symlink(link_, ignored) == name_) fs::remove(link_, ignored);
    close_sides();
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int descriptor() const { return master_; }
  // Clears the exclusive mode (TIOCEXCL) set by a client. As the terminal stays open here, it would
  // otherwise outlast the client and lock out the next one.
  void lift_exclusion() const { ioctl(slave_, TIOCNXCL); }

 private:
  void close_sides() const {
    close(slave_);
    close(master_);
  }

  fs::path link_;
  fs::path name_;
  int master_ = -1;
  int slave_ = -1;
};

DriveServer::DriveServer(const DriveServerSettings& settings, const RegisterMap& map,
                         SimulatedDrive* drive, Faults* faults)
    : settings_(settings),
      registers_(map, drive),
      faults_(faults),
      damage_(hash_bits(static_cast<std::uint64_t>(faults->link().seed), 0xda3a)),
      // The settings of a serial line do not matter: libmodbus does not open it.
      rtu_(modbus_new_rtu("pseudo-terminal", 115200, 'N', 8, 1)),
      tcp_(modbus_new_tcp("127.0.0.1", settings.tcp_port.value_or(0))) {
  if (!rtu_ || !tcp_ || modbus_set_slave(rtu_.get(), settings.unit) != 0) {
    throw Error("cannot simulate a Modbus drive: " + std::string(modbus_strerror(errno)));
  }
  for (modbus_t* context : {rtu_.get(), tcp_.get()}) {
    modbus_set_byte_timeout(context, 0, kByteTimeout_us);
    // libmodbus waits this long before it refuses values.
    modbus_set_response_timeout(context, 0, 1000);
  }
  try {
    if (socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0, replies_.data()) != 0) {
      throw Error("cannot create a pair of sockets: " + reason());
    }
    if (settings.tcp_port) listener_ = modbus_tcp_listen(tcp_.get(), 8);
    if (settings.tcp_port && listener_ < 0) {
      throw Error(
          fmt::format("cannot listen on port {} of 127.0.0.1: {}", *settings.tcp_port, reason()));
    }
    if (!settings.serial_link.empty()) terminal_ = std::make_unique<Terminal>(settings.serial_link);
  } catch (...) {
    close_lines();
    throw;
  }
  thread_ = std::thread([this] { run(); });
}

DriveServer::~DriveServer() {
  over_ = true;
  thread_.join();
  close_lines();
}

void DriveServer::close_lines() {
  for (const int client : clients_) close(client);
  for (const int line : {listener_, replies_[0], replies_[1]}) {
    if (line >= 0) close(line);
  }
}

int DriveServer::tcp_port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (listener_ >= 0) getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

void DriveServer::run() {
  while (!over_) {
    try {
      connect_or_hang_up();
      wait_for_requests();
    } catch (const Error& e) {
      // Creating the terminal is tried again.
      spdlog::warn("simulated drive: {}", e.what());
      pause(kLongestWait_ms);
    }
  }
}

void DriveServer::connect_or_hang_up() {
  if (faults_->lasting(RigFault::kCut)) {
    terminal_.reset();
    for (const int client : clients_) close(client);
    clients_.clear();
  } else if (!terminal_ && !settings_.serial_link.empty()) {
    terminal_ = std::make_unique<Terminal>(settings_.serial_link);
  }
}

void DriveServer::wait_for_requests() {
  // poll() passes over negative descriptors.
  const int terminal = terminal_ ? terminal_->descriptor() : -1;
  std::vector<pollfd> lines{{terminal, POLLIN, 0}, {listener_, POLLIN, 0}};
  for (const int client : clients_) lines.push_back({client, POLLIN, 0});
  poll(lines.data(), lines.size(), kLongestWait_ms);
  if (terminal_) terminal_->lift_exclusion();
  if (lines[0].revents != 0 && !serve(rtu_.get(), terminal)) drop_until_silence(terminal);
  if (lines[1].revents != 0) {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client >= 0) clients_.push_back(client);
  }
  for (std::size_t i = 2; i < lines.size(); ++i) {
    if (lines[i].revents == 0 || serve(tcp_.get(), lines[i].fd)) continue;
    close(lines[i].fd);
    std::erase(clients_, lines[i].fd);
  }
}

// Executes one request and sends the reply, subject to the link's faults. False: what arrived is no
// request, or the client has gone.
bool DriveServer::serve(modbus_t* context, int line) {
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
  modbus_set_socket(context, line);
  const int length = modbus_receive(context, request.data());
  if (length <= 0) return length == 0;  // 0: for another unit
  const bool is_tcp = context == tcp_.get();
  if (is_tcp) {
    const bool is_modbus = request[2] == 0 && request[3] == 0;
    if (!is_modbus) return false;
    const int unit = request[6];
    if (unit != settings_.unit && unit != 0 && unit != 255) return true;
  }
  const auto fault = faults_->next_exchange();
  if (fault == RigFault::kLostRequest || faults_->lasting(RigFault::kCut)) return true;
  const Bytes reply = reply_to(context, request.data(), length);
  if (reply.empty()) return true;
  const auto now = std::chrono::steady_clock::now();
  for (const TimedBytes& sent :
       settings_.line ? settings_.line({request.begin(), request.begin() + length}, reply)
                      : sent_for(fault, reply, is_tcp)) {
    while (!over_ && std::chrono::steady_clock::now() < now + duration_from_ms(sent.after_ms)) {
      pause(1);
    }
    if (!over_) send_bytes(line, sent.bytes);
  }
  return true;
}

// Empty for a broadcast.
DriveServer::Bytes DriveServer::reply_to(modbus_t* context, const std::uint8_t* request,
                                         int length) {
  modbus_set_socket(context, replies_[0]);
  modbus_reply(context, request, length, registers_.refreshed());
  Bytes reply = taken_reply();
  const auto at = static_cast<std::size_t>(modbus_get_header_length(context));
  const bool is_refused = reply.size() > at && (reply[at] & 0x80) != 0;
  const int function = request[at];
  const bool writes_one = function == MODBUS_FC_WRITE_SINGLE_REGISTER;
  if (is_refused || (!writes_one && function != MODBUS_FC_WRITE_MULTIPLE_REGISTERS)) return reply;
  const int address = MODBUS_GET_INT16_FROM_INT8(request, at + 1);
  const int count = writes_one ? 1 : MODBUS_GET_INT16_FROM_INT8(request, at + 3);
  if (!registers_.execute(address, count)) {
    modbus_reply_exception(context, request, MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE);
    reply = taken_reply();
  }
  return reply;
}

DriveServer::Bytes DriveServer::taken_reply() const {
  Bytes reply(MODBUS_TCP_MAX_ADU_LENGTH);
  const ssize_t size = recv(replies_[1], reply.data(), reply.size(), MSG_DONTWAIT);
  reply.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return reply;
}

// Corrupted on the serial line, a bit is flipped or the last byte is missing. TCP has its own
// checksum: there the reply is that of a gateway that mixes up replies, with a wrong transaction
// number.
std::vector<TimedBytes> DriveServer::sent_for(std::optional<RigFault> fault, Bytes reply,
                                              bool is_tcp) {
  if (fault == RigFault::kLostReply) return {};
  if (fault == RigFault::kLate) return {{faults_->link().late_ms, reply}};
  if (fault == RigFault::kDuplicated) return {{0.0, reply}, {0.0, reply}};
  if (fault == RigFault::kCorruptedReply && is_tcp) {
    reply.front() ^= 0x80;
  } else if (fault == RigFault::kCorruptedReply && damage_.chance(0.25)) {
    reply.pop_back();
  } else if (fault == RigFault::kCorruptedReply) {
    const int bit = damage_.below(static_cast<int>(8 * reply.size()));
    reply[static_cast<std::size_t>(bit / 8)] ^= static_cast<std::uint8_t>(1U << (bit % 8));
  }
  return {{0.0, std::move(reply)}};
}

}  // namespace raywalk::simulator
