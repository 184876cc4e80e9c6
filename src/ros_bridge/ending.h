#pragma once

namespace mm {

/// From here on SIGINT, SIGTERM, SIGHUP and `rosnode kill` only ask for the end: whoever moves a machine
/// stops it first, and for that ROS must still live. SIGHUP stays ignored where it was (nohup). Call it after
/// `ros::start`, once, in a node that then waits with `waitForEnd`.
void endWhileRosLives();
/// Whether the end was asked for.
bool endAsked();
/// Until the end is asked for, or ROS has been shut down.
void waitForEnd();

}  // namespace mm
