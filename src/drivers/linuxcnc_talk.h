#pragma once
#include <array>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/device_link.h"
#include "drivers/linuxcnc_protocol.h"

namespace mm {

/// The conversation with linuxcncrsh, LinuxCNC's server on TCP. A command keeps its connection busy for 0.1 s
/// or more, so questions, commands, stops and emergency stops have a connection each. But the server's
/// threads share the memory in which they take a line apart (strtok) and the number by which they see that a
/// command was received. So one line is under way at a time wherever that can be arranged, commands go one by
/// one and not beside a stop, and a time limit ends the server's wait for a number that has been overtaken.
class LinuxCncTalk {
 public:
  /// Told in the connections' threads, never while the conversation is locked.
  struct Handlers {
    /// A line of the connection for questions. @param time s, steady clock.
    std::function<void(const LinuxCncLine& line, double time)> answer;
    /// LinuxCNC has taken every command that was given. @param time s, steady clock.
    std::function<void(double time)> taken;
    std::function<void(const std::string& command)> refused;      ///< of a command, by its first word
    std::function<void(const std::string& command)> stopRefused;  ///< again and again
    std::function<void()> damaged;                                ///< a line that is no text
  };
  /// @param address `tcp:<host>:<port>`. @param hello, enable passwords. @throw InputError for the address.
  LinuxCncTalk(const std::string& address, std::string hello, std::string enable, Handlers handlers);

  /// Connects and says hello, one connection after the other. @param timeout s for each of them.
  /// @throw Error naming the address and why.
  void connect(double timeout);
  void close();
  bool connected() const;
  std::string lost() const;  ///< why a connection ended, for people; empty: none has
  const std::string& address() const { return links_[kAsking]->address(); }

  /// Asks a round of questions unless another line is under way. @return s, steady clock; 0: not now.
  /// @throw Error as DeviceLink
  double ask();
  /// The last answer of the round has come.
  void answered();
  /// Gives commands, one a line; they go one by one as LinuxCNC takes them. @throw Error as DeviceLink
  void command(const std::vector<std::string>& lines);
  /// Commands are on their way, or wait.
  bool commanding() const;
  /// Past everything that waits: drops commands that have not been sent. Any thread. @throw Error as
  /// DeviceLink
  void stop(const std::string& line) { urgent(kStopping, line); }
  void emergencyStop(const std::string& line) { urgent(kEmergency, line); }
  /// Gives on what waited until now for another line to be taken apart. @throw Error as DeviceLink
  void goOn();

 private:
  enum Link { kAsking, kCommanding, kStopping, kEmergency, kLinks };
  void take(Link link, const std::string& line, double time);
  void greet(Link link);
  void takeAcknowledgement(Link link, const std::string& command, bool refused, double time);
  void urgent(Link link, const std::string& line);
  void sendUrgent(Link link);
  bool sayAgain(Link link);
  void sendNext();
  bool free() const;

  std::string hello_, enable_;
  Handlers handlers_;
  std::array<std::unique_ptr<DeviceLink>, kLinks> links_;
  mutable std::mutex mutex_;  // everything below
  std::condition_variable freed_;
  double busySince_ = 0.0, freeAt_ = 0.0;   // s, steady clock: a line is taken apart since; not before
  std::deque<std::string> commands_;        // not sent yet
  std::array<int, kLinks> awaited_{};       // commands and stops that are sent and not acknowledged
  std::array<std::string, kLinks> urgent_;  // what a stop said last
  std::array<int, kLinks> tries_{};         // that are left to it
  bool overtaken_ = false;                  // the command under way, by a stop
  std::array<bool, kLinks> greeted_{};
  std::string refusal_;  // of a password
};

}  // namespace mm
