#include "drivers/linuxcnc_talk.h"

#include <algorithm>
#include <cctype>
#include <chrono>

#include "base/error.h"

namespace mm {
namespace {

constexpr double kParsed =
    2e-3;  // s from the answer to `enable` until the server has taken the next line apart
constexpr double kUrgent = 10e-3;            // s that a stop waits for another line to be taken apart
constexpr int kTries = 5;                    // of a stop that is refused
constexpr double kGreeting = 0.1;            // s that a greeting is waited for before the next
constexpr double kForgotten = kLinkSilence;  // s after which a line is not waited for
constexpr const char* kReception = "0.5";    // s that the server waits for a command to be received

std::string firstWord(const std::string& text) {
  std::string word = text.substr(0, text.find(' '));
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return word;
}

}  // namespace

LinuxCncTalk::LinuxCncTalk(const std::string& address, std::string hello, std::string enable,
                           Handlers handlers)
    : hello_(std::move(hello)), enable_(std::move(enable)), handlers_(std::move(handlers)) {
  for (int link = 0; link < kLinks; ++link)
    links_[link] = std::make_unique<DeviceLink>(address, [this, link](const std::string& line, double time) {
      take(static_cast<Link>(link), line, time);
    });
}

void LinuxCncTalk::connect(double timeout) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    busySince_ = freeAt_ = 0.0;
    commands_.clear();
    awaited_.fill(0);
    greeted_.fill(false);
    refusal_.clear();
    overtaken_ = false;
  }
  for (const auto& link : links_) link->connect(timeout);
  // The emergency stop first: it must get through even where nothing is answered.
  for (const Link link : {kEmergency, kStopping, kCommanding, kAsking}) greet(link);
  std::unique_lock<std::mutex> lock(mutex_);
  const auto all = [&] { return std::count(greeted_.begin(), greeted_.end(), true) == kLinks; };
  freed_.wait_for(lock, std::chrono::duration<double>(timeout), [&] { return all() || !refusal_.empty(); });
  if (all() && refusal_.empty()) return;
  throw Error(address() + " does not answer as linuxcncrsh: " +
              (refusal_.empty() ? std::string("it does not answer 'hello'") : refusal_) +
              "; is DISPLAY = linuxcncrsh in its .ini, and the password right?");
}

// One greeting after the other where they are answered at once: see the header for why.
void LinuxCncTalk::greet(Link link) {
  links_[link]->write("hello " + hello_ +
                      " measuring_machine 1.0\r\nset echo off\r\nset verbose on\r\nset enable " + enable_ +
                      "\r\nset timeout " + kReception + "\r\n");
  std::unique_lock<std::mutex> lock(mutex_);
  freed_.wait_for(lock, std::chrono::duration<double>(kGreeting),
                  [&] { return greeted_[link] || !refusal_.empty(); });
}

void LinuxCncTalk::close() {
  for (const auto& link : links_) link->close();
}

bool LinuxCncTalk::connected() const {
  return std::all_of(links_.begin(), links_.end(), [](const auto& link) { return link->connected(); });
}

std::string LinuxCncTalk::lost() const {
  for (const auto& link : links_)
    if (!link->lost().empty()) return link->lost();
  return {};
}

bool LinuxCncTalk::free() const {
  const double now = steadySeconds();
  return (busySince_ == 0.0 || now - busySince_ > kForgotten) && now >= freeAt_;
}

double LinuxCncTalk::ask() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!free()) return 0.0;
  busySince_ = steadySeconds();
  links_[kAsking]->write(LinuxCncRound::questions());
  return busySince_;
}

void LinuxCncTalk::answered() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    busySince_ = 0.0;
    sendNext();
  }
  freed_.notify_all();
}

void LinuxCncTalk::command(const std::vector<std::string>& lines) {
  const std::lock_guard<std::mutex> lock(mutex_);
  commands_.insert(commands_.end(), lines.begin(), lines.end());
  sendNext();
}

bool LinuxCncTalk::commanding() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !commands_.empty() || awaited_[kCommanding] > 0;
}

void LinuxCncTalk::goOn() {
  const std::lock_guard<std::mutex> lock(mutex_);
  sendNext();
}

// Control belongs to the connection that took it last, so each command takes it again; the answer to that
// says that the command behind it is being taken apart.
void LinuxCncTalk::sendNext() {
  const int underWay = awaited_[kCommanding] + awaited_[kStopping] + awaited_[kEmergency];
  if (commands_.empty() || underWay > 0 || !free()) return;
  const std::string line = commands_.front();
  commands_.pop_front();
  ++awaited_[kCommanding];
  busySince_ = steadySeconds();
  links_[kCommanding]->write("set enable " + enable_ + "\r\nset " + line + "\r\n");
}

void LinuxCncTalk::urgent(Link link, const std::string& line) {
  std::unique_lock<std::mutex> lock(mutex_);
  commands_.clear();
  if (awaited_[link] >= 2) return;  // the second has not been read yet: it does what this one would
  const double end = steadySeconds() + kUrgent;
  while (!free() && steadySeconds() < end) freed_.wait_for(lock, std::chrono::milliseconds(1));
  urgent_[link] = line;
  tries_[link] = kTries;
  sendUrgent(link);
}

void LinuxCncTalk::sendUrgent(Link link) {
  busySince_ = steadySeconds();
  ++awaited_[link];
  --tries_[link];
  overtaken_ = awaited_[kCommanding] > 0;
  links_[link]->write("set enable " + enable_ + "\r\nset " + urgent_[link] + "\r\n");
}

// Another client, or a command of ours that came between, took the control that a stop needs.
// @return false: it was refused as often as it may be.
bool LinuxCncTalk::sayAgain(Link link) {
  if (tries_[link] == 0) return false;
  sendUrgent(link);
  return true;
}

void LinuxCncTalk::take(Link link, const std::string& line, double time) {
  const auto parsed = parseLinuxCncLine(line);
  if (!parsed) return handlers_.damaged();
  if (parsed->word != "SET" && parsed->word != "HELLO") {
    if (link == kAsking) handlers_.answer(*parsed, time);
    return;
  }
  const std::string command = parsed->word == "HELLO" ? "HELLO" : firstWord(parsed->rest);
  const bool refused = parsed->rest.find("NAK") != std::string::npos;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!greeted_[link]) {
      if (refused && (command == "HELLO" || command == "ENABLE"))
        refusal_ = command == "HELLO" ? "it refuses the password" : "it refuses the password of 'enable'";
      greeted_[link] = command == "TIMEOUT";
    } else if (command == "ENABLE") {
      busySince_ = 0.0;
      freeAt_ = steadySeconds() + kParsed;
    }
  }
  freed_.notify_all();
  if (command == "HELLO" || command == "ECHO" || command == "VERBOSE" || command == "TIMEOUT" ||
      command == "ENABLE")
    return;
  takeAcknowledgement(link, command, refused, time);
}

void LinuxCncTalk::takeAcknowledgement(Link link, const std::string& command, bool refused, double time) {
  bool done = false, deaf = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (awaited_[link] > 0) --awaited_[link];
    done = link == kCommanding && commands_.empty();
    if (link == kCommanding && overtaken_) refused = overtaken_ = false;  // the stop was what it met
    try {
      if (link != kCommanding && refused && awaited_[link] == 0) deaf = !sayAgain(link);
      sendNext();
    } catch (const std::exception&) {
      // The connection is lost: said by `lost`.
    }
  }
  if (link == kCommanding && refused) handlers_.refused(command);
  if (deaf) handlers_.stopRefused(command);
  if (done) handlers_.taken(time);
}

}  // namespace mm
