#pragma once

namespace mm {

// How `mm` ends.
inline constexpr int kDone = 0;        // also: help and version
inline constexpr int kAnswerIsNo = 1;  // not converged, a parameter lost: the output is still written
inline constexpr int kBadInput = 2;    // bad input or usage
inline constexpr int kStopped = 130;   // by Ctrl-C (128 + SIGINT): what was done is kept

inline constexpr const char* kExitStatusHelp =
    "Exit status: 0 done; 1 the answer is no (the output is still written); 2 bad input; 130 stopped by "
    "Ctrl-C\n"
    "(results so far are kept).";

}  // namespace mm
