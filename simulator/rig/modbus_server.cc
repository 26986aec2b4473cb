#include "simulator/rig/modbus_server.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <list>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "simulator/rig/modbus_frames.h"
#include "simulator/rig/pseudo_terminal.h"
#include "simulator/rig/tcp_socket.h"

namespace raywalk::capture {
namespace {

using Steady = std::chrono::steady_clock;

// Polling interval for cuts requested by another thread.
constexpr std::chrono::milliseconds kLongestWait(20);

// A pending reply; connection 0 is the serial line.
struct Reply {
  Steady::time_point due{};
  std::uint64_t connection = 0;
  ModbusBytes bytes{};
};

struct Client {
  std::uint64_t connection = 0;
  TcpSocket socket;
  TcpReceiver receiver{};
  bool gone = false;
};

}  // namespace

class ModbusServer::Loop {
 public:
  Loop(const ModbusServerSettings& settings, DriveRegisters* registers, LinkFaults* faults)
      : settings_(settings), registers_(registers), faults_(faults) {
    if (settings.tcp_port) listener_.emplace(TcpSocket::listen_on_loopback(*settings.tcp_port));
    if (!settings.serial_link.empty()) terminal_.emplace(settings.serial_link);
    wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (wake_ < 0) throw Error("cannot create an eventfd for the simulated drive");
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  ~Loop() {
    thread_.request_stop();
    eventfd_write(wake_, 1);
    thread_.join();
    close(wake_);
  }

  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  int tcp_port() const { return listener_ ? listener_->port() : 0; }

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      try {
        apply_cut();
        wait();
        if (terminal_) serve_terminal();
        if (listener_) accept_clients();
        for (Client& client : clients_) serve(&client);
        clients_.remove_if([](const Client& client) { return client.gone; });
        send_due();
      } catch (const Error& e) {
        // Creating the terminal is retried later.
        spdlog::warn("simulated drive: {}", e.what());
        poll(nullptr, 0, static_cast<int>(kLongestWait.count()));
      }
    }
  }

  void apply_cut() {
    if (faults_->is_cut()) {
      terminal_.reset();
      for (Client& client : clients_) client.socket.reset_connection();
      clients_.clear();
      replies_.clear();
      receiver_ = {};
    } else if (!terminal_ && !settings_.serial_link.empty()) {
      terminal_.emplace(settings_.serial_link);
    }
  }

  void wait() {
    std::vector<pollfd> descriptors{{wake_, POLLIN, 0}};
    if (terminal_) descriptors.push_back({terminal_->descriptor(), POLLIN, 0});
    if (listener_) descriptors.push_back({listener_->descriptor(), POLLIN, 0});
    for (const Client& client : clients_) {
      descriptors.push_back({client.socket.descriptor(), POLLIN, 0});
    }
    Steady::time_point until = Steady::now() + kLongestWait;
    for (const Reply& reply : replies_) until = std::min(until, reply.due);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Steady::now());
    poll(descriptors.data(), descriptors.size(), static_cast<int>(std::max(left.count(), 0L)));
  }

  void serve_terminal() {
    terminal_->lift_exclusion();
    const ModbusBytes bytes = terminal_->read();
    if (bytes.empty()) return;
    receiver_.add(bytes, Steady::now());
    while (const auto request = receiver_.next()) {
      const bool is_for_all = request->unit == 0;
      if (!is_for_all && request->unit != settings_.unit) continue;
      answer(0, !is_for_all, *request,
             [&](const ModbusBytes& pdu) { return rtu_frame(request->unit, pdu); });
    }
  }

  void accept_clients() {
    while (auto socket = listener_->accept()) {
      if (faults_->is_cut()) {
        socket->reset_connection();
      } else {
        clients_.push_back({++connections_, std::move(*socket)});
      }
    }
  }

  void serve(Client* client) {
    const auto bytes = client->socket.read();
    if (!bytes) {
      client->gone = true;
      return;
    }
    client->receiver.add(*bytes);
    while (const auto request = client->receiver.next()) {
      const int unit = request->unit;
      if (unit != settings_.unit && unit != 0 && unit != 255) continue;
      answer(client->connection, true, *request, [&](const ModbusBytes& pdu) {
        return tcp_frame(request->transaction, request->unit, pdu);
      });
    }
    client->gone = client->receiver.is_broken();
  }

  // Executes the request and sends the reply, subject to the link's faults.
  template <typename Frame>
  void answer(std::uint64_t connection, bool expects_reply, const ModbusRequest& request,
              const Frame& frame) {
    const LinkFault fault = faults_->next();
    if (fault == LinkFault::kLostRequest || fault == LinkFault::kCorruptedRequest ||
        fault == LinkFault::kCut) {
      return;
    }
    const ModbusBytes pdu = registers_->answer(request.pdu);
    if (!expects_reply || fault == LinkFault::kLostReply) return;
    Reply reply{Steady::now(), connection, frame(pdu)};
    if (fault == LinkFault::kLate) reply.due += faults_->reply_delay();
    if (fault == LinkFault::kCorruptedReply) reply.bytes = damaged(connection, reply.bytes);
    replies_.push_back(reply);
    if (fault == LinkFault::kDuplicated) replies_.push_back(reply);
  }

  // TCP has its own checksum. A corrupted reply is modelled as that of a gateway that mixes up
  // replies: its transaction number is wrong.
  ModbusBytes damaged(std::uint64_t connection, const ModbusBytes& bytes) {
    if (connection == 0) return faults_->corrupt(bytes);
    ModbusBytes other = bytes;
    other[0] ^= 0x80;
    return other;
  }

  void send_due() {
    const Steady::time_point now = Steady::now();
    for (const Reply& reply : replies_) {
      if (reply.due > now) continue;
      if (reply.connection == 0 && terminal_) terminal_->write(reply.bytes);
      for (Client& client : clients_) {
        if (client.connection == reply.connection) client.socket.write(reply.bytes);
      }
    }
    std::erase_if(replies_, [now](const Reply& reply) { return reply.due <= now; });
  }

  const ModbusServerSettings settings_;
  DriveRegisters* registers_;
  LinkFaults* faults_;
  std::optional<TcpSocket> listener_;
  std::optional<PseudoTerminal> terminal_;
  RtuReceiver receiver_;
  std::list<Client> clients_;
  std::uint64_t connections_ = 0;
  std::vector<Reply> replies_;
  int wake_ = -1;
  std::jthread thread_;  // last, as it uses all of the above
};

ModbusServer::ModbusServer(const ModbusServerSettings& settings, DriveRegisters* registers,
                           LinkFaults* faults)
    : loop_(std::make_unique<Loop>(settings, registers, faults)) {}

ModbusServer::~ModbusServer() = default;

int ModbusServer::tcp_port() const { return loop_->tcp_port(); }

}  // namespace raywalk::capture
