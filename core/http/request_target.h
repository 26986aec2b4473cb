// The address of a request: "/view?x=0&z=1".
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raywalk {

inline constexpr std::size_t kMostQueryParameters = 64;

struct QueryParameter {
  std::string name{};
  std::string value{};
  std::string written{};  // "name=value" as sent
};

struct RequestTarget {
  std::string path{};                   // decoded, begins with '/'
  std::string written_path{};           // as sent
  std::vector<QueryParameter> query{};  // decoded
};

// The parts of a target in origin form (RFC 9112, 3.2.1), which is a path and perhaps a query. The
// decoded path has no empty, "." or ".." segments (but for the last, which may be empty), no
// backslashes and no control characters, and none of its slashes was written as an escape. Throws
// HttpFault 400 for anything else, such as a whole URI, an escape that is not one, or too many
// parameters.
RequestTarget parse_request_target(std::string_view target);

// The value of a parameter that is given once; none where it is absent. Throws HttpFault 400 where
// it is given twice.
std::optional<std::string> parameter_of(const RequestTarget& target, std::string_view name);

// The target, as it was written, without the parameters of that name.
std::string target_without(const RequestTarget& target, std::string_view name);

}  // namespace raywalk
