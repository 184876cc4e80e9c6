#pragma once
#include <arpa/inet.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace mm {

/// A double of a controller in test/doubles as a program of its own, and the line to its control port.
class DeviceDouble {
 public:
  explicit DeviceDouble(std::vector<std::string> arguments) {
    int out[2];
    if (pipe(out) != 0) throw std::runtime_error("pipe");
    arguments.insert(arguments.begin(), "python3");
    process_ = fork();
    if (process_ == 0) {
      dup2(out[1], 1);
      close(out[0]);
      std::vector<char*> words;
      for (std::string& argument : arguments) words.push_back(argument.data());
      words.push_back(nullptr);
      execv("/usr/bin/python3", words.data());
      _exit(127);
    }
    close(out[1]);
    std::string line;
    for (char c; read(out[0], &c, 1) == 1 && c != '\n';) line += c;
    close(out[0]);
    const auto said = nlohmann::json::parse(line);
    address_ = said.at("address");
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(said.at("control").get<int>()));
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    control_ = socket(AF_INET, SOCK_STREAM, 0);
    if (connect(control_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0)
      throw std::runtime_error("the double does not answer");
  }
  ~DeviceDouble() {
    close(control_);
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  DeviceDouble(const DeviceDouble&) = delete;
  DeviceDouble& operator=(const DeviceDouble&) = delete;

  const std::string& address() const { return address_; }
  nlohmann::json tell(const std::string& command) {
    const std::string line = command + "\n";
    if (send(control_, line.data(), line.size(), MSG_NOSIGNAL) < 0) throw std::runtime_error("send");
    std::string answer;
    for (char c; recv(control_, &c, 1, 0) == 1 && c != '\n';) answer += c;
    return nlohmann::json::parse(answer);
  }

 private:
  pid_t process_ = 0;
  int control_ = -1;
  std::string address_;
};

}  // namespace mm
