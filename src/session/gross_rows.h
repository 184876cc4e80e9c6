#pragma once
#include "session/session.h"

namespace mm {

/// Takes rows and logged values that cannot be what was meant (a row of another's time and values, a digit
/// too many, another ball's name, a sensor's error code) out of a session whose rows are in order, into
/// `Session::setAside`. Only what stands alone, far beyond everything else, and among many: a position that
/// occurs twice is taken as meant.
void setGrossRowsAside(Session& session);

/// Everything back where it was; what the reader could not make a row or a value of stays set aside.
void takeBackGrossRows(Session& session);

}  // namespace mm
