// Addresses of HTTP.
#pragma once

#include <string>

namespace raywalk::capture {

struct HttpUrl {
  std::string server;  // "http://host:port"; empty of an address without a scheme
  std::string path;    // "/" if the address names none
};

inline HttpUrl split_url(const std::string& url) {
  const std::size_t scheme = url.find("://");
  if (scheme == std::string::npos) return {"", url.starts_with('/') ? url : "/" + url};
  const std::size_t slash = url.find('/', scheme + 3);
  if (slash == std::string::npos) return {url, "/"};
  return {url.substr(0, slash), url.substr(slash)};
}

// Whether it names a server of HTTP.
inline bool is_http_url(const std::string& url) {
  const std::string server = split_url(url).server;
  return server.starts_with("http://") && server != "http://";
}

}  // namespace raywalk::capture
