#include "core/http/connection_threads.h"

#include <sys/socket.h>

#include <system_error>

namespace raywalk {

void reuse_address(socket_t socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
}

ThreadPerConnection::Accepted ThreadPerConnection::enqueue(std::function<void()> serve) {
  std::unique_lock lock(mutex_);
  join_ended();
  while (connections_.size() >= most_) {
    ended_.wait(lock);
    join_ended();
  }
  Connection& connection = connections_.emplace_back();
  try {
    connection.thread = std::thread([this, &connection, serve] {
      serve();
      const std::lock_guard ending(mutex_);
      connection.ended = true;
      ended_.notify_one();
    });
  } catch (const std::system_error&) {  // no more threads: others wait for this one
    connections_.pop_back();
    lock.unlock();
    serve();
  }
  return Accepted(true);
}

void ThreadPerConnection::shutdown() {
  // Nothing is enqueued any more.
  for (Connection& connection : connections_) connection.thread.join();
  connections_.clear();
}

// A thread that has said so needs no lock any more.
void ThreadPerConnection::join_ended() {
  for (auto connection = connections_.begin(); connection != connections_.end();) {
    if (connection->ended) {
      connection->thread.join();
      connection = connections_.erase(connection);
    } else {
      ++connection;
    }
  }
}

}  // namespace raywalk
