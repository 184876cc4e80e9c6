#pragma once
#include "model/model.h"
#include "session/session.h"

namespace mm {

/// The first of LASER's two steps, (8) and (9): from the contacts of each posture (the same readings of the
/// rotary joints) on a ball of known radius the ball's centre is fitted, and takes their place as one contact
/// with a point, at the mean of the laser's readings. The fit of the mount to these is the second step.
/// The beam within a posture is that of `model`, refitted to the centres until they stay.
/// @return a session of points; those of free balls are free. @throw InputError: no contact on a ball, less
/// than four in a posture, contacts that do not determine a centre, a machine without three linear joints.
Session centresByPosture(const Session& session, const Model& model);

}  // namespace mm
