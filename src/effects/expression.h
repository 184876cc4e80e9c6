#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace mm {

/// A formula of the user, compiled (muParser); may be evaluated by several threads at once.
class Expression {
 public:
  /// One compiled copy, for one thread at a time; goes back to the pool when destroyed.
  class Evaluation {
   public:
    explicit Evaluation(const Expression& owner);  ///< the owner must outlive it
    ~Evaluation();
    Evaluation(const Evaluation&) = delete;
    Evaluation& operator=(const Evaluation&) = delete;
    /// Values of the used variables, in the order of usedVariables(); set before the first call.
    double* variables();
    /// Value with these unknowns; NaN when a used variable is NaN.
    double operator()(const double* unknowns) const;

   private:
    const Expression& owner_;
    struct Compiled;
    std::unique_ptr<Compiled> compiled_;
    friend class Expression;
  };

  /// @param variables names that may be used. Names that begin as k1, k2 … are unknowns; `pi` and `e` are
  /// constants unless they are variables. @throw InputError (without the effect's name): syntax, with its
  /// position; unknown variables, with the known ones; no unknown at all.
  Expression(const std::string& text, std::vector<std::string> variables);
  ~Expression();

  const std::vector<std::string>& unknowns() const { return unknowns_; }  // k1, k2 … ascending
  const std::vector<int>& usedVariables() const { return used_; }         // indices of `variables`

 private:
  std::unique_ptr<Evaluation::Compiled> compile() const;

  std::string text_;
  std::vector<std::string> names_;  // of the used variables
  std::vector<std::string> unknowns_;
  std::vector<int> used_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Evaluation::Compiled>> pool_;
};

}  // namespace mm
