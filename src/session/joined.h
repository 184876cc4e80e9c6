#pragma once
#include <vector>

#include "session/session.h"

namespace mm {

/// Several sessions of one machine with one artifact as one: their observations one after the other, each
/// with its `recording`. A placement is each session's own, whatever its name, but for that of an artifact of
/// known pose: nobody knows that it was not moved. Zeros of setups are each session's own; styli and features
/// are told by their names. Sessions that bear a date stand in its order; where one does not, in the order
/// given, a day apart. Of one session nothing changes; one that is joined
/// already counts as the sessions that it is of.
/// @param sessions prepared, at the least one. @throw InputError: one of them twice, another machine,
/// artifact or compensation, touch and laser, two at the same time: names the sessions and what differs.
Session joined(std::vector<Session> sessions);

}  // namespace mm
