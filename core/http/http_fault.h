// A request that is refused.
#pragma once

#include <string>

#include "core/base/error.h"

namespace raywalk {

// What a client is told: a status of 400 to 599 and one sentence.
class HttpFault : public Error {
 public:
  HttpFault(int status, const std::string& sentence) : Error(sentence), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

}  // namespace raywalk
