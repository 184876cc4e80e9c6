#pragma once
#include <cstddef>
#include <vector>

#include "diagnosis/question_list.h"
#include "diagnosis/search.h"

namespace mm {

/// The questions of a long session: of all that may be asked, only those come into the search that come near
/// to being an answer, because the columns of all would neither fit into memory nor be compared in time. What
/// was found may have hidden something else, so all must be asked again beside it, until nothing new comes.
class Shortlist {
 public:
  /// @param space, q: must outlive it. Counts the questions in `q`.
  Shortlist(const ResidualSpace& space, Questions& q);
  /// Asks all causes and profiles beside what was found, and adds to the questions those that gain most.
  /// @param found its members move with their groups, as do those of `other`. @return whether one that is new
  /// is worth its price.
  bool extend(Explanation& found, Explanation* other = nullptr);
  /// Causes that the session cannot show.
  const std::vector<NotShown>& notShown() const { return notShown_; }

 private:
  struct Candidate;

  std::vector<Candidate> bestCandidates(const Search& search, const Explanation& found);
  /// Those of one part of a list that are not asked yet, or with other shapes.
  /// @param before groups in all lists before this part.
  void addCandidates(const Search& search, const Evidence& evidence, const Groups& part, std::size_t before,
                     const Explanation& found, std::vector<Candidate>& candidates) const;
  /// Puts them among the questions, all in the order of the lists: of causes that act alike the first is
  /// named. @return where each group that was there is now.
  std::vector<int> take(std::vector<Candidate> candidates);

  Questions& q_;
  std::vector<QuestionList> lists_;  // causes, profiles
  std::vector<std::size_t> order_;   // a group of the questions: its place in all lists
  std::vector<NotShown> notShown_;
  bool first_ = true;
};

/// Shapes whose columns are made and compared at a time.
constexpr std::size_t kShapesTogether = 60;

}  // namespace mm
