#pragma once
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "workbench/server.h"

namespace mm {

/// The live connection of one client. It holds one state that is being sent and the latest one after it.
class LiveSocket : public std::enable_shared_from_this<LiveSocket> {
 public:
  LiveSocket(boost::beast::tcp_stream stream, Server& server, std::uint64_t client);

  /// Takes the request that asks for it.
  void begin(const boost::beast::http::request<boost::beast::http::string_body>& request);
  /// Sends a state, or keeps it in place of the one that waits.
  void offer(std::shared_ptr<const std::string> state);
  void close();  ///< at once
  std::uint64_t client() const { return client_; }

 private:
  void read();
  void write();
  void leave();

  Server& server_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::beast::flat_buffer buffer_;
  std::shared_ptr<const std::string> sending_, next_;
  std::uint64_t client_;
  RateLimit rate_;  // its own: whoever asks for many pages does not silence a heartbeat
  bool open_ = false, left_ = false;
};

}  // namespace mm
