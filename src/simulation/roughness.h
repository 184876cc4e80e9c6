#pragma once
#include <string>

namespace YAML {
class Node;
}

namespace mm {

/// How a session is rougher than white noise on a perfect artifact. Every size is a factor of the
/// repeatability of what the plan measures (contact, laser reading or reference); 0: not rough in this way.
struct Roughness {
  double drift = 0.0;       // RMS of the wandering of each joint over the session, about its mean
  double correlated = 0.0;  // standard deviation of the noise, which then remembers the reading before
  double form = 0.0;        // RMS of a ball's form, of its radius error and of each component of its centre's
  double sensors = 0.0;     // factor of noise, steps and offsets of the temperatures, which come late
  double tails = 0.0;       // standard deviation of the noise, which is Student's t; few readings are wild
  double quantised = 0.0;   // step of the readings

  /// Nothing of all: white noise on a perfect artifact.
  bool none() const {
    return drift == 0.0 && correlated == 0.0 && form == 0.0 && sensors == 0.0 && tails == 0.0 &&
           quantised == 0.0;
  }
  /// Factor of the white noise's standard deviation.
  double noiseFactor() const;
  /// As for `change`; `none` where it is not rough.
  std::string text() const;

  /// Changes what is named in words: `drift,form=0.5`, `all`, `all=2,quantised`, `none`. A word without a
  /// size means 1, `quantised` 3; `all` is all but `quantised`. @throw InputError naming `where`.
  void change(const std::string& words, const std::string& where);
  /// From the words of a plan. @throw InputError naming source, line and key.
  static Roughness read(const YAML::Node& node, const std::string& source);
};

}  // namespace mm
