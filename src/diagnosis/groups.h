#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "estimation/drift.h"
#include "model/model.h"

// A cause is what engineers call one: backlash of x. It is asked as a group of shapes, the effects and values
// that it may have (a degree, a period); a shape has members where several effects make it together. What the
// sample says of causes is told by slots (posterior/slots.h): a cause, or a set of rivals of which one acts.

namespace mm {

/// Log-prior penalty of a sign that is seldom met, ln 10: of causes that act alike it is not the first, and
/// still among them.
constexpr double kSeldomSign = 2.3;

/// One shape that a cause may have: its main columns and, with less weight, those that it has beside them.
struct Shape {
  EffectSpec spec;                // what would be added
  EffectPtr effect;               // of `spec`
  std::vector<double> nonlinear;  // values of its nonlinear parameters (a period, a time constant), SI
  int first = 0, count = 0;       // of Groups::columns
  int main = 0;                   // of these, the first are those of the effect itself
  /// Against its cause, in nats: which of the effects that a cause may be is as likely as another, and then
  /// which of the shapes of that effect.
  double price = 0.0;
  std::vector<EffectSpec>
      mixed;  // not empty: a shape made of several members of the family, a main column each
  /// Coefficient of the first column beyond which sizes are met less and less: that of Parameter::usual,
  /// where nothing of it is known a part of its bound.
  double usual = std::numeric_limits<double>::infinity();
  bool seldomNegative = false;  // that coefficient (Parameter::seldomNegative)
  bool curved = false;          // its size follows a curve along a joint: SizeAlong::kAsACurve
  /// Of a coefficient of the first column, in nats. A half-t of three degrees of freedom, whose odds fall
  /// with the third power of the size: it can still be shown, and does not stand where an ordinary size of
  /// another cause explains as much (a scale, and an expansion of forty times that of steel at a temperature
  /// that hardly changed).
  double priceOfSize(double coefficient) const {
    const double of = coefficient / usual;
    return 1.5 * std::log1p(of * of) + (seldomNegative && coefficient < 0.0 ? kSeldomSign : 0.0);
  }
};

/// One question of a diagnosis: a physical cause with everything that it may look like, or a profile.
struct Group {
  std::string key;  // type and what says where it acts, without what says its shape only
  std::vector<Shape> shapes;
  double met = 1.0;  // Nature::met; of a profile less
  /// Keys of other causes that are a part of this one as real parts are made (Effect::freedom), with their
  /// usual share of its size.
  std::map<std::string, double> parts;
  bool profile = false;
  int variables = 0;  // of a profile
  bool dependsOnTime = false;
  std::vector<std::string>
      notRecorded;  // inputs of it that the session does not have, made up for the question
};

/// A member of the catalogue that the session cannot show.
struct NotShown {
  EffectSpec spec;
  EffectPtr effect;
  std::string why;
};

/// All questions that are asked of a session, with their columns: whitened by the stated noise, not
/// projected, each of unit root mean square after what the model's unknowns absorb, times the weight that it
/// has in its shape.
struct Groups {
  std::vector<Group> groups;
  RowMatrix columns;  // length x all
  std::vector<NotShown> notShown;
  int causes = 0;  // groups that are no profiles
};

/// One after the other. @param more is emptied.
void append(Groups& to, Groups more);
/// Whether an effect of this canonical spec is in the model.
bool inModel(const Model& model, const EffectSpec& spec);

/// The key of the cause that an effect belongs to.
std::string causeOf(const Effect& effect);

}  // namespace mm
