#include "drivers/device_link.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/asio.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "drivers/serial_address.h"

namespace mm {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kLongestLine = 4096;  // what is longer is no line of a controller

}  // namespace

struct DeviceLink::Port {
  asio::io_context context;
  std::optional<asio::generic::stream_protocol::socket> socket;
  std::optional<asio::serial_port> serial;
  std::array<char, 1024> buffer;
};

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

DeviceLink::DeviceLink(std::string address, LineHandler handler)
    : address_(std::move(address)), handler_(std::move(handler)) {
  const std::string form = "tcp:<host>:<port> or serial:<device>[:<baud>]";
  if (isSerialAddress(address_)) {
    const SerialAddress line = parseSerialAddress(address_, false, form);
    device_ = line.device;
    if (line.baud > 0) baud_ = line.baud;
    return;
  }
  if (address_.rfind("tcp:", 0) != 0)
    throw InputError("address '" + address_ + "' is neither tcp:<host>:<port> nor serial:<device>[:<baud>]");
  const std::size_t colon = address_.rfind(':');
  if (colon <= 4) throw InputError("address '" + address_ + "' has no port; write tcp:<host>:<port>");
  host_ = address_.substr(4, colon - 4);
  const std::string port = address_.substr(colon + 1);
  const bool digits =
      !port.empty() && port.size() < 6 && port.find_first_not_of("0123456789") == std::string::npos;
  port_ = digits ? std::stoi(port) : 0;
  if (port_ < 1 || port_ > 65535)
    throw InputError("address '" + address_ + "': '" + port + "' is not a number from 1 to 65535 (port)");
}

DeviceLink::DeviceLink(std::string address, std::vector<std::string> program, LineHandler handler)
    : address_(std::move(address)), program_(std::move(program)), handler_(std::move(handler)) {}

DeviceLink::~DeviceLink() { close(); }

void DeviceLink::connect(double timeout, int lent) {
  close();
  auto port = std::make_unique<Port>();
  try {
    if (!program_.empty()) {
      port->socket.emplace(port->context, asio::generic::stream_protocol(AF_UNIX, 0),
                           child_.start(program_, lent));
    } else if (device_.empty()) {
      asio::ip::tcp::resolver resolver(port->context);
      const auto found = resolver.resolve(host_, std::to_string(port_));
      asio::ip::tcp::socket socket(port->context);
      boost::system::error_code failed = asio::error::timed_out;
      asio::async_connect(socket, found,
                          [&](const boost::system::error_code& code, const auto&) { failed = code; });
      port->context.run_for(
          std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(timeout)));
      if (failed) {
        socket.close();
        port->context.restart();
        port->context.run();
        throw boost::system::system_error(failed);
      }
      port->context.restart();
      socket.set_option(asio::ip::tcp::no_delay(true));
      socket.native_non_blocking(true);
      port->socket.emplace(std::move(socket));
    } else {
      port->serial.emplace(port->context, device_);
      port->serial->set_option(asio::serial_port::baud_rate(static_cast<unsigned>(baud_)));
      port->serial->set_option(asio::serial_port::character_size(8));
      port->serial->set_option(asio::serial_port::parity(asio::serial_port::parity::none));
      port->serial->set_option(asio::serial_port::stop_bits(asio::serial_port::stop_bits::one));
      port->serial->set_option(asio::serial_port::flow_control(asio::serial_port::flow_control::none));
    }
  } catch (const boost::system::system_error& e) {
    throw Error(address_ + ": cannot be opened: " + e.code().message());
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    open_ = std::move(port);
    lost_.clear();
    line_.clear();
    connected_ = true;
  }
  answerAtOnce();
  readOn();
  thread_ = std::thread([this] { open_->context.run(); });
}

void DeviceLink::close() {
  connected_ = false;
  if (open_) {
    asio::post(open_->context, [this] {
      boost::system::error_code ignored;
      if (open_->socket) open_->socket->close(ignored);
      if (open_->serial) open_->serial->close(ignored);
    });
  }
  if (thread_.joinable()) thread_.join();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    open_.reset();
  }
  child_.end();
}

int DeviceLink::descriptor() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!open_) return -1;
  return open_->socket ? open_->socket->native_handle() : open_->serial->native_handle();
}

std::string DeviceLink::lost() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return lost_;
}

void DeviceLink::lose(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (connected_ && lost_.empty()) lost_ = address_ + ": " + why;
  connected_ = false;
}

void DeviceLink::readOn() {
  const auto handle = [this](const boost::system::error_code& failed, std::size_t bytes) {
    if (failed) return lose("the connection ended: " + failed.message());
    take(bytes, steadySeconds());
    answerAtOnce();
    readOn();
  };
  if (open_->socket)
    open_->socket->async_read_some(asio::buffer(open_->buffer), handle);
  else
    open_->serial->async_read_some(asio::buffer(open_->buffer), handle);
}

// A peer that sends small packets waits for the acknowledgement of each: 40 ms, unless it comes at once.
void DeviceLink::answerAtOnce() {
  if (!open_->socket || host_.empty()) return;
  const int on = 1;
  ::setsockopt(open_->socket->native_handle(), IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
}

void DeviceLink::take(std::size_t bytes, double time) {
  for (std::size_t i = 0; i < bytes; ++i) {
    const char c = open_->buffer[i];
    if (c == '\n' || c == '\r' || line_.size() >= kLongestLine) {
      if (!line_.empty()) handler_(line_, time);
      line_.clear();
      if (c == '\n' || c == '\r') continue;
    }
    line_ += c;
  }
}

void DeviceLink::write(const std::string& bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!connected_ || !open_) throw Error(lost_.empty() ? address_ + ": not connected" : lost_);
  const ssize_t sent = open_->socket ? ::send(open_->socket->native_handle(), bytes.data(), bytes.size(),
                                              MSG_NOSIGNAL | MSG_DONTWAIT)
                                     : ::write(open_->serial->native_handle(), bytes.data(), bytes.size());
  if (sent == static_cast<ssize_t>(bytes.size())) return;
  throw Error(address_ + ": the device accepts no data" +
              (sent < 0 && errno != EAGAIN ? std::string(": ") + std::strerror(errno) : std::string()));
}

}  // namespace mm
