#pragma once
#include "simulation/source.h"

namespace mm {

/// A ram that sags as it extends: a cantilever under a load at its end and its own weight.
class GravitySag : public Source {
 public:
  /// @param joint that extends the ram, from `retracted` (m) to `extended` (m). @param drop m at full
  /// extension.
  GravitySag(int joint, Direction vertical, double retracted, double extended, double drop)
      : joint_(joint),
        vertical_(vertical),
        retracted_(retracted),
        length_(extended - retracted),
        drop_(drop) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Direction vertical_;
  double retracted_, length_, drop_;
};

/// Creep: a steady drift in time.
class TimeDrift : public Source {
 public:
  /// @param rate m/s.
  TimeDrift(Direction direction, double rate) : direction_(direction), rate_(rate) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  Direction direction_;
  double rate_;
};

/// A clamp that slips, and gives way a little after it.
class Slip : public Source {
 public:
  /// @param size m or rad, at once. @param at s.
  Slip(Direction direction, double size, double at) : direction_(direction), size_(size), at_(at) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  Direction direction_;
  double size_, at_;
};

/// Warm-up after switching on: a fast and a slow part of the structure come to their temperatures.
class WarmUp : public Source {
 public:
  /// @param size m in the end. @param timeConstant s, of the slow part.
  WarmUp(Direction direction, double size, double timeConstant)
      : direction_(direction), size_(size), timeConstant_(timeConstant) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  Direction direction_;
  double size_, timeConstant_;
};

/// A screw that heats itself by running grows from its fixed bearing.
class ScrewWarmUp : public Source {
 public:
  /// @param fixed reading at which the bearing holds it, m. @param strain in the end. @param timeConstant s.
  ScrewWarmUp(int joint, double fixed, double strain, double timeConstant)
      : joint_(joint), fixed_(fixed), strain_(strain), timeConstant_(timeConstant) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  double fixed_, strain_, timeConstant_;
};

/// Something that was logged (humidity, pressure, load) moves the tip, or stretches an axis.
class CovariateError : public Source {
 public:
  /// @param perUnit m per unit, or with `axis` 1 per unit times the axis' position.
  CovariateError(int covariate, double reference, Direction direction, int axis, double perUnit)
      : covariate_(covariate), reference_(reference), direction_(direction), axis_(axis), perUnit_(perUnit) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int covariate_;
  double reference_;
  Direction direction_;
  int axis_;
  double perUnit_;
};

}  // namespace mm
