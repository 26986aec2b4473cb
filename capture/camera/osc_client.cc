#include "capture/camera/osc_client.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <thread>

#include "capture/base/device_fault.h"
#include "capture/base/http_url.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr const char* kInfo = "/osc/info";
constexpr const char* kState = "/osc/state";
constexpr const char* kExecute = "/osc/commands/execute";
constexpr const char* kStatus = "/osc/commands/status";

// Headers required by the Open Spherical Camera API (protocol pages of Google and of Insta360).
const httplib::Headers kHeaders = {{"Accept", "*/*"}, {"X-XSRF-Protected", "1"}};
constexpr const char* kJson = "application/json;charset=utf-8";

constexpr int kAttempts = 3;
constexpr double kPauseBetweenAttempts_ms = 250.0;
constexpr std::size_t kLargestAnswer = std::size_t{4} << 20;
// More than any camera's panorama: 8 bytes for each pixel of 11008x5504 (Ricoh Theta X) fit in.
constexpr std::size_t kLargestPicture = std::size_t{512} << 20;

// A member that should be an object; an empty object if it is not one.
Json object_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? *found : Json::object();
}

// Text as it is, any other type as JSON.
std::string shown_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return {};
  return found->is_string() ? found->get<std::string>() : found->dump();
}

// The file named by the results of a picture; empty if none.
std::string file_in(const Json& results) {
  // Level 2; then level 1 as Google and as Ricoh name it.
  for (const char* key : {"fileUrl", "fileUri", "_fileUri"}) {
    std::string file = shown_at(results, key);
    if (!file.empty()) return file;
  }
  return {};
}

void throw_if_refused(const Json& reply) {
  if (!reply.contains("error")) return;
  const Json error = object_at(reply, "error");
  throw OscRefusal(shown_at(error, "code"), one_line(shown_at(error, "message")));
}

bool has_level_2(const Json& info) {
  const Json levels = list_at(info, "apiLevel");
  return std::find(levels.begin(), levels.end(), Json(2)) != levels.end();
}

std::string checked_url(const std::string& url) {
  const HttpUrl split = split_url(url);
  const bool has_path = split.path.find_first_not_of('/') != std::string::npos;
  if (is_http_url(url) && !has_path) return split.server;
  throw UsageError("camera.osc.url is " + excerpt(url) +
                   "; it must be an address like http://192.168.1.1");
}

// Ends a request after its total time. httplib's timeouts are per system call, so a server that
// sends single bytes could delay it without end.
class RequestDeadline {
 public:
  RequestDeadline(httplib::Client& client, double timeout_ms)
      : thread_([this, &client, timeout_ms](const std::stop_token& token) {
          std::unique_lock lock(mutex_);
          const auto never = [] { return false; };
          ended_.wait_for(lock, token, duration_from_ms(timeout_ms), never);
          if (token.stop_requested()) return;
          passed_ = true;
          client.stop();
        }) {}

  bool end() {
    thread_.request_stop();
    thread_.join();
    return passed_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any ended_;
  bool passed_ = false;
  std::jthread thread_;
};

}  // namespace

// --- HTTP ----------------------------------------------------------------------------------------

struct OscClient::Reply {
  int status = 0;
  std::string body;
};

// A connection on which every request has a time limit, whatever the server does.
class OscClient::Http {
 public:
  Http(const std::string& url, double connect_timeout_ms)
      : url_(url), connect_timeout_ms_(connect_timeout_ms), client_(url) {
    const auto timeout = duration_from_ms(connect_timeout_ms);
    client_.set_connection_timeout(timeout);
    client_.set_read_timeout(timeout);
    client_.set_write_timeout(timeout);
    client_.set_keep_alive(true);
    client_.set_tcp_nodelay(true);
  }

  // The next request opens a new connection. A kept connection may have been closed by the server,
  // which is noticed only when a request on it is lost.
  void close() { client_.stop(); }

  // Posts the JSON text `body`, or gets the path if it is empty. Throws DeviceFault: kNoContact
  // without a connection or a complete reply, kWrongDevice if the reply is longer than max_bytes;
  // Interrupted while a body arrives. HTTP errors are returned as replies.
  Reply send(const std::string& path, const std::string& body, double total_timeout_ms,
             std::size_t max_bytes) {
    Reply reply;
    bool too_long = false;
    httplib::Request request;
    request.method = body.empty() ? "GET" : "POST";
    request.path = path;
    request.body = body;
    request.headers = kHeaders;
    if (!body.empty()) request.headers.emplace("Content-Type", kJson);
    request.content_receiver = [&](const char* data, std::size_t length, std::uint64_t,
                                   std::uint64_t) {
      too_long = reply.body.size() + length > max_bytes;
      if (too_long || interrupt_requested()) return false;
      reply.body.append(data, length);
      return true;
    };
    RequestDeadline deadline(client_, total_timeout_ms);
    httplib::Response response;
    httplib::Error error = httplib::Error::Success;
    const bool answered = client_.send(request, response, error);
    const bool late = deadline.end();
    if (!answered) throw_if_interrupted();
    if (too_long) {
      throw DeviceFault(
          FaultKind::kWrongDevice,
          fmt::format("{}{}: the answer is longer than {} bytes; check camera.osc.url", url_, path,
                      max_bytes));
    }
    if (!answered) refuse_no_answer(path, error, late ? total_timeout_ms : connect_timeout_ms_);
    reply.status = response.status;
    return reply;
  }

 private:
  [[noreturn]] void refuse_no_answer(const std::string& path, httplib::Error error,
                                     double timeout_ms) const {
    using httplib::Error;
    const bool unconnected = error == Error::Connection || error == Error::ConnectionTimeout;
    throw DeviceFault(
        FaultKind::kNoContact,
        unconnected
            ? fmt::format("{}{}: no connection to the camera; switch it on, let this computer join "
                          "its network, and check camera.osc.url",
                          url_, path)
            : fmt::format("{}{}: no complete reply from the camera within {:g} ms; check that it "
                          "is near and switched on",
                          url_, path, timeout_ms));
  }

  std::string url_;
  double connect_timeout_ms_;
  httplib::Client client_;
};

OscClient::Reply OscClient::ask(const std::string& path, const std::string& body, Repeat repeat,
                                bool for_picture) {
  for (int attempt = 1;; ++attempt) {
    throw_if_interrupted();
    try {
      Reply reply = for_picture
                        ? http_->send(path, body, config_.picture_timeout_ms, kLargestPicture)
                        : http_->send(path, body, 2.0 * config_.connect_timeout_ms, kLargestAnswer);
      if (for_picture || !reply.body.empty() || reply.status != 200) return reply;
      throw DeviceFault(FaultKind::kNoContact,
                        url() + path + ": the camera answers with nothing; switch it off and on");
    } catch (const DeviceFault& fault) {
      const bool again = repeat == Repeat::kIfUnanswered && attempt < kAttempts &&
                         fault.kind() == FaultKind::kNoContact;
      if (!again) throw;
      http_->close();
      clock_.sleep(duration_from_ms(kPauseBetweenAttempts_ms));
    }
  }
}

// --- The API -------------------------------------------------------------------------------------

std::string text_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

std::optional<double> number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<std::int64_t> count_at(const Json& object, const char* key) {
  constexpr double kLargest = 9007199254740992.0;  // 2^53
  const auto number = number_at(object, key);
  if (!number || !(*number >= 0.0 && *number <= kLargest)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

Json list_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : Json::array();
}

bool OscRefusal::is_temporary() const {
  // Theta: "cannot be executed due to the camera status", "cannot be received temporarily"; Google:
  // cameraInExclusiveUse.
  static const std::array<std::string, 3> passing = {"disabledCommand", "serviceUnavailable",
                                                     "cameraInExclusiveUse"};
  return std::find(passing.begin(), passing.end(), code_) != passing.end();
}

// The reply to a command.
struct OscClient::Answer {
  bool done = false;
  std::string id;  // of a command in progress
  Json results;    // an object; empty while in progress

  OscCommand command() const { return {done, id, file_in(results)}; }
};

OscClient::OscClient(const OscConfig& config, Clock& clock) : config_(config), clock_(clock) {
  config_.url = checked_url(config.url);
  http_ = std::make_unique<Http>(config_.url, config_.connect_timeout_ms);
}

OscClient::~OscClient() = default;

Json OscClient::object_from(const std::string& path, const std::string& body, Repeat repeat) {
  const Reply reply = ask(path, body, repeat, false);
  Json json = Json::parse(reply.body, nullptr, false);
  if (json.is_object()) return json;
  const std::string where = url() + path;
  if (reply.status >= 500) {
    throw DeviceFault(FaultKind::kNoContact,
                      fmt::format("{}: the camera fails with HTTP {}; switch it off and on", where,
                                  reply.status));
  }
  throw DeviceFault(
      FaultKind::kWrongDevice,
      reply.status >= 400
          ? fmt::format("{}: HTTP {}: this is not a camera of the Open Spherical Camera API; check "
                        "camera.osc.url",
                        where, reply.status)
          : fmt::format("{}: the answer is no JSON object but {}; check camera.osc.url", where,
                        excerpt(reply.body)));
}

Json OscClient::info() {
  Json info = object_from(kInfo, "");
  if (info.contains("model") || info.contains("manufacturer")) return info;
  throw DeviceFault(FaultKind::kWrongDevice, url() + kInfo +
                                                 ": names neither manufacturer nor model: " +
                                                 excerpt(info.dump()) + "; check camera.osc.url");
}

Json OscClient::state() {
  const Json json = object_from(kState, "{}");
  const auto state = json.find("state");
  if (state != json.end() && state->is_object()) return *state;
  throw DeviceFault(FaultKind::kWrongDevice, url() + kState + ": holds no state: " +
                                                 excerpt(json.dump()) + "; check camera.osc.url");
}

OscClient::Answer OscClient::answer_from(const std::string& path, const Json& request,
                                         Repeat repeat) {
  const Json reply = object_from(path, request.dump(), repeat);
  throw_if_refused(reply);
  const std::string state = shown_at(reply, "state");
  if (state == "inProgress") {
    Answer answer{false, shown_at(reply, "id"), Json::object()};
    if (!answer.id.empty()) return answer;
    throw DeviceFault(FaultKind::kWrongDevice,
                      url() + path + ": a command in progress without an id: " +
                          excerpt(reply.dump()) + "; update the camera's firmware");
  }
  // At level 1 an answer with results has no state.
  if (state == "done" || (state.empty() && reply.contains("results"))) {
    return {true, {}, object_at(reply, "results")};
  }
  throw DeviceFault(FaultKind::kWrongDevice,
                    url() + path + ": neither done nor in progress: " + excerpt(reply.dump()) +
                        "; update the camera's firmware");
}

OscClient::Answer OscClient::execute(const std::string& name, Json parameters, Repeat repeat) {
  if (!session_id_.empty()) parameters["sessionId"] = session_id_;
  Json request = {{"name", name}};
  if (!parameters.empty()) request["parameters"] = std::move(parameters);
  return answer_from(kExecute, request, repeat);
}

void OscClient::open_session() {
  if (!level_known_) {
    needs_session_ = !has_level_2(info()) || shown_at(state(), "_apiVersion") == "1";
    level_known_ = true;
  }
  if (!needs_session_) return;
  session_id_.clear();
  try {
    const Json results =
        execute("camera.startSession", Json::object(), Repeat::kIfUnanswered).results;
    session_id_ = shown_at(results, "sessionId");
    execute("camera.setOptions", {{"options", {{"clientVersion", 2}}}}, Repeat::kIfUnanswered);
    session_id_.clear();
    needs_session_ = false;
  } catch (const OscRefusal& refusal) {
    if (refusal.is_temporary()) {
      throw DeviceFault(FaultKind::kBusy, url() + ": " + refusal.what() + " (" + refusal.code() +
                                              "); close other programs that use the camera");
    }
    // A camera without sessions has level 2; one with sessions but without clientVersion has
    // level 1.
    needs_session_ = !session_id_.empty();
  }
}

Json OscClient::options(const std::vector<std::string>& names) {
  std::vector<std::string> wanted;
  std::copy_if(names.begin(), names.end(), std::back_inserter(wanted),
               [this](const std::string& name) { return !unknown_options_.contains(name); });
  if (wanted.empty()) return Json::object();
  try {
    const Answer answer =
        execute("camera.getOptions", {{"optionNames", wanted}}, Repeat::kIfUnanswered);
    return object_at(answer.results, "options");
  } catch (const OscRefusal& refusal) {
    if (refusal.is_temporary() && wanted.size() == 1) throw;
    if (wanted.size() == 1) {
      unknown_options_.insert(wanted.front());
      return Json::object();
    }
  }
  // A single unknown name makes a camera refuse all: request each option alone.
  Json all = Json::object();
  for (const std::string& name : wanted) all.update(options({name}));
  return all;
}

void OscClient::set_options(const Json& options) {
  // Setting the same values twice is harmless.
  execute("camera.setOptions", {{"options", options}}, Repeat::kIfUnanswered);
}

OscCommand OscClient::begin_picture() {
  http_->close();
  return execute("camera.takePicture", Json::object(), Repeat::kNever).command();
}

OscCommand OscClient::status_of(const std::string& id) {
  return answer_from(kStatus, {{"id", id}}, Repeat::kIfUnanswered).command();
}

std::string OscClient::fetch(const std::string& file) {
  // The host in a file's address is the camera's own view, which differs from the configured one
  // behind an access point or a forwarded port.
  const std::string path = needs_session_ ? kExecute : split_url(file).path;
  const Json command = {{"name", "camera.getImage"}, {"parameters", {{"fileUri", file}}}};
  Reply reply = ask(path, needs_session_ ? command.dump() : "", Repeat::kIfUnanswered, true);
  if (reply.status == 200) return std::move(reply.body);
  throw DeviceFault(FaultKind::kBadPicture,
                    fmt::format("{}: HTTP {} instead of the picture; check the camera's card",
                                url() + path, reply.status));
}

}  // namespace raywalk::capture
