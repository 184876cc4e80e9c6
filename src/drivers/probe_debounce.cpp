#include "drivers/probe_debounce.h"

#include <cmath>

namespace mm {

void ProbeDebounce::reset() { *this = ProbeDebounce(settings_); }

void ProbeDebounce::refuse(const std::string& why) {
  ++refused_;
  complaint_ = why;
  pending_.reset();
  settled_ = true;
}

void ProbeDebounce::edge(const ProbeEdge& edge) {
  if (!edge.closed) {
    if (pending_) ++bounces_;
    level_ = false;
    lastEdge_ = edge.time;
    return;
  }
  // Closed again soon after it opened, and after a contact: still the same touch.
  const bool again = settled_ && edge.time - lastEdge_ < settings_.longest;
  level_ = true;
  lastEdge_ = edge.time;
  if (pending_ || again) {
    ++bounces_;
    return;
  }
  settled_ = false;
  pending_ = edge;
}

std::optional<ProbeEdge> ProbeDebounce::poll(double time, bool closed, bool probing) {
  if (!closed || probing)
    closedSince_.reset();
  else if (!closedSince_)
    closedSince_ = time;
  if (closedSince_ && time - *closedSince_ >= settings_.stuck)
    complaint_ =
        "the probe is stuck: its switch stays closed outside of a probing move; look at the stylus "
        "and the cable";
  if (!pending_) return std::nullopt;
  if (!level_ && time - pending_->time >= settings_.longest) {
    refuse("the probe opened again at once: a jolt, or a loose contact; no contact was published");
    return std::nullopt;
  }
  if (!level_ || time - lastEdge_ < settings_.settle) return std::nullopt;
  if (!pending_->probing) {
    refuse("the probe tripped outside of a probing move: a collision? No contact was published");
    return std::nullopt;
  }
  bool latched = !pending_->position.empty();
  for (const double value : pending_->position) latched = latched && std::isfinite(value);
  if (!latched) {
    refuse("the controller latched no position at the trip; no contact was published");
    return std::nullopt;
  }
  const ProbeEdge contact = *pending_;
  pending_.reset();
  settled_ = true;
  complaint_.clear();
  return contact;
}

}  // namespace mm
