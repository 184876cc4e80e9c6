#include "base/cancel_scope.h"

#include "base/error.h"

namespace mm {
namespace {

thread_local const CancelScope* innermost = nullptr;

}  // namespace

CancelScope::CancelScope(std::function<bool()> asked) : asked_(std::move(asked)), outer_(innermost) {
  innermost = this;
}

CancelScope::~CancelScope() { innermost = outer_; }

CancelScope::Lent::Lent(const CancelScope* scope) : before_(innermost) { innermost = scope; }

CancelScope::Lent::~Lent() { innermost = before_; }

const CancelScope* CancelScope::current() { return innermost; }

void CancelScope::check() {
  if (innermost != nullptr && innermost->asked()) throw Cancelled("cancelled; nothing was changed");
}

}  // namespace mm
