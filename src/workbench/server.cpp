#include "workbench/server.h"

#include <boost/asio/post.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "workbench/access.h"
#include "workbench/http_connection.h"
#include "workbench/live_socket.h"

namespace mm {
namespace {

using boost::asio::ip::tcp;

// that the kernel holds for us: one that finds no place tries again after a second, whoever took them
constexpr int kBacklog = 1024;
constexpr std::chrono::milliseconds kWithoutHandles{200};  // until an accept is tried again
constexpr std::chrono::milliseconds kShortest{30};         // between two states, however much is new
constexpr std::chrono::milliseconds kAfterFailure{500};    // until a state is tried again

}  // namespace

WebAnswer WebAnswer::say(unsigned status, const std::string& message) {
  WebAnswer answer = text(jsonLine({{"message", message}}));
  answer.status = status;
  return answer;
}

WebAnswer WebAnswer::text(std::string body, std::string type) {
  WebAnswer answer;
  answer.body = std::make_shared<const std::string>(std::move(body));
  answer.type = std::move(type);
  return answer;
}

bool RateLimit::take(std::chrono::steady_clock::time_point now) {
  left_ = std::min(perSecond_, left_ + perSecond_ * std::chrono::duration<double>(now - last_).count());
  last_ = now;
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  return true;
}

Server::Server(ServerOptions options, WebHandler& handler)
    : options_(std::move(options)), handler_(handler), rate_(options_.requestsASecond) {
  if (options_.token.empty()) options_.token = newToken();
  boost::system::error_code failed;
  const auto address = boost::asio::ip::make_address(options_.address, failed);
  if (failed)
    throw InputError("--address: '" + options_.address +
                     "' is not an IP address; 127.0.0.1 is this computer only");
  if (address.is_unspecified() && options_.hosts.empty())
    throw InputError("--address: " + options_.address +
                     " is every address of this computer; say with --host (hosts:=) by which name or address "
                     "browsers reach it, or listen on that address");
  if (options_.port > 65535)
    throw InputError("--port: " + std::to_string(options_.port) + " is above 65535; 0 takes any free port");
  const tcp::endpoint endpoint(address, static_cast<unsigned short>(options_.port));
  acceptor_.open(endpoint.protocol(), failed);
  if (!failed) acceptor_.set_option(boost::asio::socket_base::reuse_address(true), failed);
  if (!failed) acceptor_.bind(endpoint, failed);
  if (!failed) acceptor_.listen(kBacklog, failed);
  if (failed)
    throw InputError("port " + std::to_string(options_.port) + " of " + options_.address +
                     " cannot be opened (" + failed.message() +
                     "); choose another, or 0 for any that is free");
  port_ = acceptor_.local_endpoint().port();
  std::vector<std::string> names = options_.hosts;
  if (address.is_unspecified()) names.insert(names.end(), {"127.0.0.1", "::1", "localhost"});
  hosts_ = hostsOf(options_.address, port_, names);
  accept();
  tick();
  thread_ = std::thread([this] {
    for (;;) {
      try {
        context_.run();
        return;
      } catch (const std::exception&) {  // of one connection: the others go on
      }
    }
  });
}

Server::~Server() {
  boost::asio::post(context_, [this] {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    timer_.cancel();
    pause_.cancel();
    for (auto* list : {&waiting_, &trusted_})
      while (!list->empty()) list->front()->close();
    while (!sockets_.empty()) sockets_.front()->close();
    context_.stop();
  });
  thread_.join();
}

void Server::accept() {
  if (waiting_.size() >= options_.mostWaiting) {
    const auto due = waiting_.front()->since() + options_.undisturbed;
    if (due > std::chrono::steady_clock::now()) return acceptAt(due);
  }
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    if (error)  // no file handle left: others must end first
      return acceptAt(std::chrono::steady_clock::now() + kWithoutHandles);
    try {
      admit(std::move(socket));
    } catch (const std::exception&) {  // of this connection: the next is accepted all the same
    }
    accept();
  });
}

void Server::acceptAt(std::chrono::steady_clock::time_point when) {
  pause_.expires_at(when);
  pause_.async_wait([this](boost::system::error_code) {  // cancelled: a place is free
    if (acceptor_.is_open()) accept();
  });
}

void Server::admit(tcp::socket socket) {
  const auto connection = std::make_shared<HttpConnection>(std::move(socket), *this);
  while (waiting_.size() >= options_.mostWaiting) waiting_.front()->close();
  waiting_.push_back(connection);
  if (waiting_.size() + trusted_.size() + sockets_.size() > options_.mostConnections)
    connection->turnAway(503, "too many connections; close other pages of the workbench");
  else
    connection->readHeader();
}

void Server::trusted(HttpConnection* connection) {
  for (auto i = waiting_.begin(); i != waiting_.end(); ++i) {
    if (i->get() != connection) continue;
    trusted_.splice(trusted_.end(), waiting_, i);
    pause_.cancel();
    return;
  }
}

void Server::left(HttpConnection* connection) {
  const auto same = [connection](const auto& other) { return other.get() == connection; };
  waiting_.remove_if(same);
  trusted_.remove_if(same);
  pause_.cancel();
}

std::shared_ptr<void> Server::placeForUpload() {
  if (!upload_.expired()) return nullptr;
  const auto place = std::make_shared<char>();
  upload_ = place;
  return place;
}

void Server::left(LiveSocket* socket) {
  const std::uint64_t client = socket->client();
  sockets_.remove_if([socket](const auto& other) { return other.get() == socket; });
  handler_.gone(client);
}

void Server::tick() {
  told_ = std::chrono::steady_clock::now();
  tickAt(told_ + kAfterFailure);  // the handler may throw, and the next state is due all the same
  if (!sockets_.empty()) {
    std::string state = "{\"sequence\":" + std::to_string(++sequence_) +
                        ",\"clients\":" + std::to_string(sockets_.size()) + "," + handler_.live() + "}";
    const auto shared = std::make_shared<const std::string>(std::move(state));
    for (const auto& socket : sockets_) socket->offer(shared);
  }
  tickAt(told_ + handler_.period());
}

void Server::tickAt(std::chrono::steady_clock::time_point when) {
  timer_.expires_at(when);
  timer_.async_wait([this](boost::system::error_code stopped) {
    if (!stopped) tick();
  });
}

void Server::wake() {
  if (waking_.exchange(true)) return;  // a state is due already
  boost::asio::post(context_, [this] {
    waking_ = false;
    if (acceptor_.is_open()) tickAt(std::max(told_ + kShortest, std::chrono::steady_clock::now()));
  });
}

std::string Server::url() const {
  const std::string& host = options_.hosts.empty() ? options_.address : options_.hosts.front();
  return "http://" + withPort(host, port_) + "/?token=" + options_.token;
}

}  // namespace mm
