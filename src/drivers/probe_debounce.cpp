#include "drivers/probe_debounce.h"

namespace mm {

void ProbeDebounce::forget() {
  pending_.reset();
  closedSince_.reset();
  level_ = settled_ = false;
}

std::vector<ProbeEdge> ProbeDebounce::take(const std::vector<ProbeEdge>& edges, const AxesState& state,
                                           bool probing) {
  std::vector<ProbeEdge> trips;
  for (const ProbeEdge& edge : edges) {
    settle(edge.time, trips);
    takeEdge(edge);
  }
  settle(state.time, trips);
  watchLevel(state, probing);
  return trips;
}

void ProbeDebounce::takeEdge(const ProbeEdge& edge) {
  // Closed again soon after it opened, and after a trip: still the same touch.
  const bool again = settled_ && edge.time - lastEdge_ < settings_.longest;
  level_ = edge.closed;
  lastEdge_ = edge.time;
  if (pending_ || (edge.closed && again)) {
    ++bounces_;
  } else if (edge.closed) {
    settled_ = false;
    pending_ = edge;
  }
}

void ProbeDebounce::settle(double time, std::vector<ProbeEdge>& trips) {
  if (!pending_) return;
  if (level_ ? time - lastEdge_ < settings_.settle : time - pending_->time < settings_.longest) return;
  if (level_) {
    trips.push_back(*pending_);
    complaint_.clear();
  } else {
    ++jolts_;
    complaint_ = "the probe opened again at once: a shock or a loose connection; no contact was published";
  }
  pending_.reset();
  settled_ = true;
}

void ProbeDebounce::watchLevel(const AxesState& state, bool probing) {
  if (!state.probeClosed || probing)
    closedSince_.reset();
  else if (!closedSince_)
    closedSince_ = state.time;
  if (closedSince_ && state.time - *closedSince_ >= settings_.stuck)
    complaint_ =
        "the probe is stuck: its switch stays closed outside a probing move; check the stylus and the cable";
}

}  // namespace mm
