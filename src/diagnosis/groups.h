#pragma once
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "estimation/noise_fit.h"
#include "estimation/residual_space.h"

namespace mm {

/// One shape that a cause may have: its main columns and, with less weight, those that it has beside them.
struct Shape {
  EffectSpec spec;                // what would be added
  EffectPtr effect;               // of `spec`
  std::vector<double> nonlinear;  // values of its nonlinear parameters (a period, a time constant), SI
  int first = 0, count = 0;       // of Groups::columns
  int main = 0;                   // of these, the first are those of the effect itself
  std::vector<EffectSpec>
      mixed;  // not empty: a shape made of several members of the family, a main column each
};

/// One question of a diagnosis: a physical cause with everything that it may look like, or a profile.
struct Group {
  std::string key;  // type and what says where it acts, without what says its shape only
  std::vector<Shape> shapes;
  int shapesAsked = 0;  // where `shapes` are only the likely ones of more
  bool profile = false;
  int variables = 0;  // of a profile
  bool dependsOnTime = false;
  std::vector<std::string>
      notRecorded;  // inputs of it that the session does not have, made up for the question
  /// Log of the number of its shapes, one of which is to be chosen.
  double priceOfShape() const {
    return std::log(std::max<double>({1.0, double(shapesAsked), double(shapes.size())}));
  }
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

/// Questions that may be asked of a session. Their columns are made when they are wanted: all of them are
/// some thousands, of the length of the session.
class QuestionList {
 public:
  /// The causes of the catalogue, as its effects declare them.
  static QuestionList causes(const ResidualSpace& space);
  /// A smooth function of one recorded variable along each direction.
  static QuestionList profiles(const ResidualSpace& space);
  /// Profiles of two variables, asked only where structure is left.
  static QuestionList pairs(const ResidualSpace& space);

  std::size_t size() const { return groups_.size(); }  ///< groups
  /// The end of a part that begins with a group and has about so many shapes.
  std::size_t endOfPart(std::size_t first, std::size_t shapes) const;
  /// Some of them, with their columns; those that the session cannot show are left out, and listed.
  Groups made(std::size_t first, std::size_t count) const;
  Groups all() const { return made(0, size()); }

 private:
  explicit QuestionList(const ResidualSpace& space) : space_(&space) {}
  struct ProfileOf;
  static QuestionList of(const ResidualSpace& space, const std::vector<ProfileOf>& profiles);
  /// A shape to be made: the effect and values of its nonlinear parameters.
  struct Wanted {
    std::size_t group;
    EffectPtr effect;
    std::vector<double> nonlinear;
  };
  const ResidualSpace* space_;
  std::vector<Group> groups_;     // without shapes
  std::vector<EffectPtr> first_;  // a group: the first effect of it
  std::vector<std::string> why_;  // a group: not empty where it cannot be shown
  std::vector<Wanted> wanted_;    // in the order of their groups
};

/// One after the other. @param more is emptied.
void append(Groups& to, Groups more);
/// One of the groups, with a copy of its columns. @param shapes of it, ascending.
Groups oneOf(const Groups& all, std::size_t group, const std::vector<int>& shapes);
Groups oneOf(const Groups& all, std::size_t group);

/// Makes the columns of a shape at other values of its nonlinear parameters.
class GroupColumns {
 public:
  explicit GroupColumns(const ResidualSpace& space) : space_(space) {}  ///< which must outlive it
  /// @return length x k, weighted; no columns where nothing is seen.
  RowMatrix operator()(const EffectPtr& effect, const std::vector<double>& nonlinear) const;

 private:
  const ResidualSpace& space_;
};

/// Shapes that the effects of the model may have beside those they have in it: blocks of known size.
std::vector<RandomBlock> shapesOfTheModel(const ResidualSpace& space);

/// How much the size of a cause changes over the travel of a joint along which it is known to change.
constexpr double kVariation = 0.15;
/// Columns of an effect (a row for each of `rows`), from minus themselves at one end of a joint's travel to
/// themselves at the other; zero where it never moved.
void varyAlong(const Problem& problem, const std::vector<int>& rows, int joint, RowMatrix& columns);

/// Whether an effect of this canonical spec is in the model.
bool inModel(const Model& model, const EffectSpec& spec);

/// The key of the cause that an effect belongs to.
std::string causeOf(const Effect& effect);

}  // namespace mm
