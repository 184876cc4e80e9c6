#include "workbench/http_connection.h"

#include <boost/beast/http/span_body.hpp>
#include <boost/beast/websocket.hpp>
#include <sstream>

#include "workbench/live_socket.h"

namespace mm {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

const char* const kUpload = "/upload";

/// What a request may bring, beside an upload, which has a place of its own.
std::size_t largestBody(const std::string& path, const ServerOptions& options) {
  const bool import = path == "/action/preview" || path == "/action/import";
  return import ? options.largestImport : options.largestBody;
}
// What a page may do that names no policy: nothing.
const char* const kNothing =
    "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// An answer on its way. Its body is shared with whoever gave it and with others that take the same one.
struct Sending {
  http::response<http::span_body<const char>> response;
  std::shared_ptr<const std::string> body;
};

}  // namespace

HttpConnection::HttpConnection(tcp::socket socket, Server& server)
    : server_(server), stream_(std::move(socket)) {
  beast::error_code ignored;
  std::ostringstream peer;
  peer << stream_.socket().remote_endpoint(ignored);
  peer_ = peer.str();
}

void HttpConnection::readHeader() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(server_.options_.largestHeader));
  parser_->body_limit(server_.options_.largestUpload);
  stream_.expires_after(server_.options_.headerTime);
  auto self = shared_from_this();
  http::async_read_header(stream_, buffer_, *parser_,
                          [self](beast::error_code error, std::size_t) { self->headerRead(error); });
}

void HttpConnection::failed(beast::error_code error) {
  if (error == http::error::body_limit)
    return turnAway(413, "more than " + std::to_string(server_.options_.largestUpload >> 20) +
                             " MB; put the file on this computer and open it with mm workbench");
  if (error == http::error::header_limit) return turnAway(431, "the request's header is too long");
  if (error.category() == http::make_error_code(http::error::bad_target).category() &&
      error != http::error::end_of_stream && error != http::error::partial_message)
    return turnAway(400, "not an HTTP request: " + error.message());
  leave();
}

std::string HttpConnection::header(http::field name) const {
  const auto value = parser_->get()[name];
  return std::string(value.data(), value.size());
}

WebAnswer HttpConnection::refusal(const Target& target) const {
  const auto& request = parser_->get();
  if (request.count(http::field::host) != 1 || !hostAllowed(header(http::field::host), server_.hosts_))
    return WebAnswer::say(421, "the request names '" + header(http::field::host).substr(0, 100) +
                                   "' as its host, and this server is not known under it; open the address "
                                   "that it printed, or start it with that name (--host, or hosts:=)");
  if (request.count(http::field::origin) > 1 || !originAllowed(header(http::field::origin), server_.hosts_))
    return WebAnswer::say(403, "the request comes from a page of another origin");
  if (!target.wellFormed) return WebAnswer::say(400, "the request's target is not well formed");
  const auto shown = request["X-Workbench-Token"];
  if (!sameToken(target.token, server_.options_.token) &&
      !sameToken(std::string(shown.data(), shown.size()), server_.options_.token))
    return WebAnswer::say(403, "missing or wrong access token; open the address that mm workbench printed");
  if (request.method() != http::verb::get && request.method() != http::verb::post)
    return WebAnswer::say(405, "only GET and POST are supported");
  const auto length = parser_->content_length();
  const std::size_t most = largestBody(target.path, server_.options_);
  if (length && *length > most && target.path != kUpload)
    return WebAnswer::say(413, "the request's body has more than " + std::to_string(most >> 10) + " KB");
  return WebAnswer();
}

void HttpConnection::headerRead(beast::error_code error) {
  if (error) return failed(error);
  const auto raw = parser_->get().target();
  const Target target = targetOf(std::string(raw.data(), raw.size()));
  const WebAnswer refused = refusal(target);
  if (refused.status != 200) return send(refused, true);
  if (!trusted_) server_.trusted(this);
  trusted_ = true;
  if (!server_.rate_.take(std::chrono::steady_clock::now()))
    return send(WebAnswer::say(429, "too many requests; wait a second"), false);
  if (target.path == "/live" && beast::websocket::is_upgrade(parser_->get())) return becomeLive();
  readBody(target);
}

void HttpConnection::readBody(const Target& target) {
  if (target.path == kUpload) {
    // a body that only grows would be copied whenever it has outgrown its place, and everybody would wait
    if (!parser_->content_length())
      return turnAway(411, "a file is sent with its length (Content-Length), as browsers do");
    upload_ = server_.placeForUpload();
    if (!upload_)
      return turnAway(409, "another file is being sent; send this one again after it has arrived");
  } else {
    parser_->body_limit(largestBody(target.path, server_.options_));
  }
  stream_.expires_after(server_.options_.bodyTime);
  auto self = shared_from_this();
  http::async_read(stream_, buffer_, *parser_, [self, target](beast::error_code error, std::size_t) {
    if (error == http::error::body_limit && target.path != kUpload)
      return self->turnAway(413, "the request's body is too long");
    if (error) return self->failed(error);
    const WebAnswer answer = self->answerOf(target);
    self->upload_ = nullptr;
    self->send(answer, false);
  });
}

WebAnswer HttpConnection::answerOf(const Target& target) {
  try {
    if (parser_->get().method() == http::verb::get) return server_.handler_.get(target.path);
    return server_.handler_.post(target.path, target.query, std::move(parser_->get().body()), peer_);
  } catch (const std::exception& e) {
    return WebAnswer::say(400, e.what());
  }
}

void HttpConnection::becomeLive() {
  if (server_.sockets_.size() >= server_.options_.mostSockets)
    return send(WebAnswer::say(503, "too many pages of the workbench are open; close one"), true);
  const auto socket = std::make_shared<LiveSocket>(std::move(stream_), server_, ++server_.clients_);
  server_.sockets_.push_back(socket);
  const auto request = parser_->release();
  left_ = true;
  server_.left(this);  // last use of this connection's place; `self` of the caller still holds it
  socket->begin(request);
}

void HttpConnection::turnAway(unsigned status, const std::string& message) {
  send(WebAnswer::say(status, message), true);
}

void HttpConnection::send(const WebAnswer& answer, bool last) {
  const auto sending = std::make_shared<Sending>();
  auto& response = sending->response;
  response.version(11);
  response.result(answer.status);
  response.set(http::field::content_type, answer.type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Content-Security-Policy", answer.policy.empty() ? kNothing : answer.policy);
  if (!answer.fileName.empty())
    response.set(http::field::content_disposition, "attachment; filename=\"" + answer.fileName + "\"");
  sending->body = answer.body;
  if (answer.body) response.body() = {answer.body->data(), answer.body->size()};
  const bool keep = !last && parser_ && parser_->is_done() && parser_->get().keep_alive();
  response.keep_alive(keep);
  response.prepare_payload();
  sending_ = sending;
  stream_.expires_after(server_.options_.answerTime);
  auto self = shared_from_this();
  http::async_write(stream_, response, [self, keep](beast::error_code error, std::size_t) {
    self->sending_ = nullptr;
    if (error || !keep) return self->leave();
    self->readHeader();
  });
}

void HttpConnection::close() {
  stream_.close();
  leave();
}

void HttpConnection::leave() {
  if (left_) return;
  left_ = true;
  upload_ = nullptr;
  beast::error_code ignored;
  stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
  stream_.close();
  server_.left(this);
}

}  // namespace mm
