// What httplib's servers need to serve clients that are slow or silent.
#pragma once

#include <httplib.h>

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace raywalk {

// For httplib::Server::set_socket_options. httplib's default, SO_REUSEPORT, would let two servers
// share a port; SO_REUSEADDR only allows reusing a port that was closed a moment ago.
void reuse_address(socket_t socket);

// A thread for every connection, up to `most` at a time; further ones wait until one has ended.
// httplib's own pool has eight threads, so that eight clients that are slow or silent keep all
// others waiting until one of them times out.
class ThreadPerConnection final : public httplib::TaskQueue {
 public:
  // httplib returns nothing here up to 0.14, later whether the task was accepted.
  using Accepted = decltype(std::declval<httplib::TaskQueue&>().enqueue(std::function<void()>()));

  explicit ThreadPerConnection(std::size_t most) : most_(most) {}

  Accepted enqueue(std::function<void()> serve) override;
  // Waits for them.
  void shutdown() override;

 private:
  struct Connection {
    std::thread thread{};
    bool ended = false;
  };

  void join_ended();

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::list<Connection> connections_;  // a list, so that each stays where its thread found it
};

}  // namespace raywalk
