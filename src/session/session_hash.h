#pragma once
#include <string>

#include "session/session.h"

namespace mm {

/// 32 hexadecimal digits over everything in a prepared session that a result can depend on: machine (its
/// URDF), artifact, observations, series. Not: source, warning, rows, epoch. Equal content, to the bit, gives
/// an equal hash whatever it was read from. It tells sessions apart; it is no protection against a forger.
std::string sessionHash(const Session& session);

}  // namespace mm
