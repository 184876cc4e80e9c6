#pragma once
#include <functional>

namespace mm {

/// A request to cancel, for work deep inside a long computation that nobody hands it to: while a scope lives,
/// the loops of its thread can ask. Scopes nest; the innermost counts.
class CancelScope {
 public:
  /// @param asked whether to stop; may be empty: never. Called often, also by threads that were given the
  /// scope.
  explicit CancelScope(std::function<bool()> asked);
  ~CancelScope();
  CancelScope(const CancelScope&) = delete;
  CancelScope& operator=(const CancelScope&) = delete;

  /// The scope of one thread lent to another that works for it, for as long as this lives; null: none.
  class Lent {
   public:
    explicit Lent(const CancelScope* scope);  ///< of another thread; null: none
    ~Lent();
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;

   private:
    const CancelScope* before_;
  };

  /// The scope of this thread; null: none.
  static const CancelScope* current();
  bool asked() const { return asked_ && asked_(); }
  /// @throw Cancelled when this thread's scope was asked to stop.
  static void check();

 private:
  std::function<bool()> asked_;
  const CancelScope* outer_;
};

}  // namespace mm
