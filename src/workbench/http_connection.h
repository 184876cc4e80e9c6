#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>

#include "workbench/access.h"
#include "workbench/server.h"

namespace mm {

/// One connection of a client: requests one after the other, until it becomes a live connection or ends.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(boost::asio::ip::tcp::socket socket, Server& server);

  void readHeader();                                                      ///< waits for a request
  void close();                                                           ///< at once
  std::chrono::steady_clock::time_point since() const { return since_; }  ///< accepted
  /// Says in one answer why nothing else is answered, and ends.
  void turnAway(unsigned status, const std::string& message);

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  void headerRead(boost::beast::error_code error);
  /// Why the request is refused before its body is read; status 200: it is not.
  WebAnswer refusal(const Target& target) const;
  void readBody(const Target& target);
  void becomeLive();
  WebAnswer answerOf(const Target& target);
  void send(const WebAnswer& answer, bool last);
  void failed(boost::beast::error_code error);
  void leave();
  std::string header(boost::beast::http::field name) const;

  Server& server_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<Parser> parser_;
  std::shared_ptr<void> sending_;  // the answer, until it is taken
  std::shared_ptr<void> upload_;   // the place for the file that is being sent
  std::string peer_;
  bool trusted_ = false, left_ = false;
  const std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
};

}  // namespace mm
