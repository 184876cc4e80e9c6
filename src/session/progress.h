#pragma once
#include <functional>

namespace mm {

/// Told how far a long piece of work is, from 0 to 1; may be empty. It may throw Cancelled, which stops the
/// work.
using ProgressCallback = std::function<void(double fraction)>;

}  // namespace mm
