#include "workbench/live_socket.h"

#include <boost/beast/core/buffers_to_string.hpp>

namespace mm {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr std::size_t kLargestMessage = 4096;  // of a client: heartbeats
constexpr int kSendBuffer = 64 << 10;          // bytes

}  // namespace

LiveSocket::LiveSocket(beast::tcp_stream stream, Server& server, std::uint64_t client)
    : server_(server), socket_(std::move(stream)), client_(client), rate_(server.options_.messagesASecond) {}

void LiveSocket::begin(const http::request<http::string_body>& request) {
  // the socket has times of its own from here on
  beast::get_lowest_layer(socket_).expires_never();
  websocket::stream_base::timeout times{};
  times.handshake_timeout = server_.options_.headerTime;
  times.idle_timeout = server_.options_.idleTime;
  times.keep_alive_pings = true;
  socket_.set_option(times);
  socket_.read_message_max(kLargestMessage);
  // what waits for a client that stalls waits here, where only the latest counts, not with the kernel
  beast::error_code ignored;
  beast::get_lowest_layer(socket_).socket().set_option(
      boost::asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  auto self = shared_from_this();
  socket_.async_accept(request, [self](beast::error_code error) {
    if (error) return self->leave();
    self->open_ = true;
    self->socket_.text(true);
    self->server_.handler_.came(self->client_);
    self->offer(std::make_shared<const std::string>("{\"client\":" + std::to_string(self->client_) + "}"));
    self->read();
    self->server_.wake();
  });
}

void LiveSocket::read() {
  auto self = shared_from_this();
  socket_.async_read(buffer_, [self](beast::error_code error, std::size_t) {
    if (error) return self->leave();
    const std::string text = beast::buffers_to_string(self->buffer_.data());
    self->buffer_.consume(self->buffer_.size());
    if (self->rate_.take(std::chrono::steady_clock::now())) {
      try {
        self->server_.handler_.heard(self->client_, text);
      } catch (const std::exception&) {
        return self->close();  // no client of ours says such things
      }
    }
    self->read();
  });
}

void LiveSocket::offer(std::shared_ptr<const std::string> state) {
  if (!open_ || left_) return;
  next_ = std::move(state);
  if (!sending_) write();
}

void LiveSocket::write() {
  sending_ = std::move(next_);
  next_ = nullptr;
  auto self = shared_from_this();
  socket_.async_write(boost::asio::buffer(*sending_), [self](beast::error_code error, std::size_t) {
    self->sending_ = nullptr;
    if (error) return self->leave();
    if (self->next_ && !self->left_) self->write();
  });
}

void LiveSocket::close() {
  beast::get_lowest_layer(socket_).close();
  leave();
}

void LiveSocket::leave() {
  if (left_) return;
  left_ = true;
  beast::get_lowest_layer(socket_).close();
  server_.left(this);
}

}  // namespace mm
