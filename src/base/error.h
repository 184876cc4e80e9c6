#pragma once
#include <stdexcept>
#include <string>

namespace mm {

/// Root of everything the package throws; `what()` is one line for people.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bad input or usage: the message names file, line or field, value, bound and remedy. `mm` exits with 2.
class InputError : public Error {
 public:
  using Error::Error;
};

/// The input is well formed, but the answer cannot be computed from it. `mm` exits with 1.
class NumericalError : public Error {
 public:
  using Error::Error;
};

/// The caller asked to stop.
class Cancelled : public Error {
 public:
  using Error::Error;
};

}  // namespace mm
