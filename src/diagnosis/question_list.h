#pragma once
#include <string>
#include <vector>

#include "diagnosis/groups.h"
#include "diagnosis/shape_maker.h"

namespace mm {

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
    SizeAlong along = SizeAlong::kSlowly;
  };
  /// Shapes of several members of a family together: a group, and which of the shapes that are made.
  struct Mixed {
    std::size_t group;
    std::vector<std::size_t> members;
  };
  std::vector<Wanted> wantedOf(std::size_t first, std::size_t count) const;
  std::vector<MadeShape> shapesOf(const std::vector<Wanted>& wanted) const;
  void dropAliases(const std::vector<Wanted>& wanted, std::vector<MadeShape>& made) const;
  static std::vector<Mixed> mixedOf(const Groups& groups, std::size_t first,
                                    const std::vector<Wanted>& wanted, const std::vector<MadeShape>& made);
  static void setPrices(std::vector<Shape>& shapes, int passedOver);
  void dropEmpty(Groups& out, std::size_t first, const std::vector<std::string>& why) const;

  const ResidualSpace* space_;
  std::vector<Group> groups_;     // without shapes
  std::vector<EffectPtr> first_;  // a group: the first effect of it
  std::vector<int> passedOver_;   // a group: its shapes that a quick look left out
  std::vector<std::string> why_;  // a group: not empty where it cannot be shown
  std::vector<Wanted> wanted_;    // in the order of their groups
};

}  // namespace mm
