// For tests: what a server is sent and answers, and how requests are refused.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <sstream>
#include <string>

#include "render/serve/view_request.h"
#include "render/serve/web_server.h"

namespace raywalk::render {

// All that a server on loopback sends until it closes the connection, to whatever text.
inline std::string reply_to_text(int port, const std::string& text) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  // A server may close before it has read all.
  static_cast<void>(send(socket, text.data(), text.size(), MSG_NOSIGNAL));
  std::string reply;
  std::array<char, 4096> bytes{};
  for (ssize_t count = 0; (count = recv(socket, bytes.data(), bytes.size(), 0)) > 0;) {
    reply.append(bytes.data(), static_cast<std::size_t>(count));
  }
  close(socket);
  return reply;
}

// The status that `action` is refused with, 0 where it throws nothing; expects the message to be
// one line.
template <typename Action>
int fault_of(const Action& action, std::string* message = nullptr) {
  try {
    action();
  } catch (const HttpFault& fault) {
    const std::string text = fault.what();
    EXPECT_FALSE(text.empty());
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    if (message != nullptr) *message = text;
    return fault.status();
  }
  return 0;
}

// Of "x=0&z=1", without escapes.
inline ViewRequest view_of(const std::string& text) {
  std::multimap<std::string, std::string> query;
  std::istringstream parameters(text);
  for (std::string parameter; std::getline(parameters, parameter, '&');) {
    const std::size_t equals = std::min(parameter.find('='), parameter.size() - 1);
    query.emplace(parameter.substr(0, equals), parameter.substr(equals + 1));
  }
  return parse_view_request(query);
}

}  // namespace raywalk::render
