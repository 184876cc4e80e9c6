#pragma once
#include <map>
#include <vector>

#include "diagnosis/posterior_search.h"
#include "diagnosis/question_list.h"

namespace mm {

/// Which of all shapes a sample is drawn of: those that the data make likelier than they were before, beside
/// the likeliest others. Of some thousands a hundred are left; what a sample finds is asked of all again.
class LikelyShapes {
 public:
  /// @param space, questions: must outlive it; the questions get what is likely, in the order of the lists.
  LikelyShapes(const ResidualSpace& space, Questions& questions, double statedFreedoms);

  /// Two greedy searches, one from white noise only and one from the noise that alone explains most: each
  /// takes up the likeliest cause beside those before it, until none is likelier than not. @param variance of
  /// the white noise, a data row.
  void walk(const Eigen::VectorXd& variance);
  /// Where the likeliest walk ended.
  Explanation found() const;
  /// The same walks, at other weights of the rows.
  void weigh(const Eigen::VectorXd& variance);
  /// Where the walks ended: sets of causes and the noise beside them, to begin a sample with.
  std::vector<PosteriorStart> starts() const;
  /// Asks everything again beside what a sample found. @param instead and beside all of it but one.
  /// @return whether there is anything new.
  bool extend(const PosteriorSample& sample, bool instead);
  /// Puts the causes that are not likely behind the others, each with its likeliest shape and its probability
  /// beside what the sample found: so that all that were asked can be told.
  void appendTheRest(PosteriorAnswer& answer);

 private:
  /// A shape as it is kept.
  struct Kept {
    Shape shape;
    RowMatrix columns;
  };
  /// A shape that acts: of a group of the lists, at a size of the grid.
  struct Taken {
    std::size_t group = 0;
    int shape = 0, size = 0;
  };
  /// What one look says of a shape.
  struct Asked {
    Taken taken;            // at its likeliest size
    double likelier = 0.0;  // log of how much likelier the data make it, its sizes averaged
    double logOdds = 0.0;   // that it acts, with what was known before
    Kept kept;              // without columns, where kept_ has them
  };
  struct Walk {
    std::vector<Taken> set;
    NoiseState noise;
  };
  /// Some groups of a list, as a sample would see them.
  struct ListPart {
    std::size_t first = 0;  // number of its first group
    std::vector<Group> groups;
    PosteriorProblem problem;
  };
  /// What acts, and the noise: all parts of the lists are asked beside it.
  struct Beside {
    std::vector<Taken> set;
    NoiseState noise;                  // the set is a block of it, of its size
    std::vector<RandomBlock> scatter;  // with the set
    std::shared_ptr<const WhitenedRows> whitened;
  };
  enum class Wanted { kNearTheLikeliest, kLikelierThanBefore, kOneOfEach };
  Beside besideOf(const NoiseState& noise, const std::vector<Taken>& set) const;
  std::vector<Asked> ask(const NoiseState& noise, const std::vector<Taken>& set, Wanted wanted);
  std::vector<Asked> askPart(ListPart& part, const Beside& beside, Wanted wanted) const;
  void addList(QuestionList list);
  ListPart partOf(const QuestionList& list, std::size_t before, std::size_t first, std::size_t end);
  static const NoiseState& noiseOf(const PosteriorSample& sample);
  std::vector<Taken> foundBy(const PosteriorSample& sample) const;
  bool isKept(const Taken& t) const;
  bool take(std::vector<Asked> asked);
  /// Two causes that act for one that was found, each far behind it alone: for each of the likeliest first
  /// ones, what completes it. @return whether any is new.
  bool takeTwoForOne(const Walk& found);
  /// Asked beside the set of a walk and one more; as log densities, those of the walk with both.
  std::vector<Asked> askBeside(const Walk& walk, const Asked& one);
  bool takeRefined(const std::vector<Taken>& set, const NoiseState& noise);
  void fill();
  ActingSet acting(const std::vector<Taken>& set) const;
  /// Takes up the likeliest cause again and again.
  void grow(Walk& walk);
  /// What scatters or drifts may be a cause: for each term of the noise, is there one that does nearly what
  /// the term did, and explains as much where that is small? @return whether the walk goes on from there.
  bool exchange(Walk& walk);
  bool endsLikeAnother(const Walk& walk) const;  // with the same causes
  /// A term of the noise: the state where it is small, and what it did (length).
  struct Term {
    NoiseState small;
    Eigen::VectorXd did;
  };
  std::vector<Term> termsOf(const Walk& walk) const;
  /// Causes that do nearly the same, at the size at which they do.
  std::vector<Asked> alike(const Eigen::VectorXd& did) const;
  PosteriorProblem problemBeside(const std::vector<Taken>& set, ActingSet& acting) const;
  NoiseState fitted(const std::vector<Taken>& set, const NoiseState& from,
                    NoiseTerms terms = NoiseTerms::kFitted) const;
  double densityOf(const Walk& walk) const;
  const Walk& likeliestWalk() const;

  static constexpr double kNear = 10.0;  // nats behind the likeliest: what is further behind is not drawn
  const ResidualSpace& space_;
  Questions& q_;
  const double statedFreedoms_;
  std::vector<QuestionList> lists_;
  std::vector<std::vector<ListPart>> made_;  // a list: its parts, where they are kept
  std::map<std::size_t, Group> groups_;      // of the lists, by number: without shapes
  std::map<std::size_t, std::map<int, Kept>> kept_;
  std::vector<NotShown> notShown_;
  std::vector<Walk> walks_;
};

}  // namespace mm
