#pragma once
#include <string>
#include <vector>

#include "base/error.h"
#include "simulation/catalogue.h"
#include "visits.h"

namespace mm {

/// A source that the plan does not make act: it does not vary what the error depends on.
class SourceNotShown : public InputError {
 public:
  using InputError::InputError;
};

/// What an uncatalogued source truly is: what a formula that explains it should be made of.
struct UncataloguedTruth {
  std::string cause;  // in plain words
  /// Names as a comparison gives them: `x`, `x speed`, `x travel direction`, `time`, `temperature bed`,
  /// `humidity`; `tip speed` and `approach` depend on the velocities of all linear joints.
  std::vector<std::string> variables;
  std::string direction;  // x, y, z, a joint, or `approach`
};

/// One kind of physical effect that no effect of the catalogue describes.
struct UncataloguedKind {
  enum class Along {
    kOwnAxis,    // the joint of the key `axis`
    kDirection,  // the key `direction`
    kThird,      // square to the joints of the keys `axis` and `across`
    kApproach    // the way the probe comes
  };
  std::string type, cause;
  Along along = Along::kDirection;
  std::vector<SourceKind::KeyRule> keys;
  std::vector<std::string> variables;                // a key in brackets stands for its value: `[axis] speed`
  double (*shape)(const VisitedInstant&) = nullptr;  // of any size
  std::vector<SourceKind::NumberRule> shapeNumbers = {};  // of which it is made; after the size
  bool qualified = false;                                 // less what a qualification of the probe takes out
};

/// All of them; every type begins with `uncatalogued_`.
const std::vector<UncataloguedKind>& uncataloguedKinds();
bool isUncatalogued(const std::string& type);
/// @throw InputError when the source is not uncatalogued.
UncataloguedTruth uncataloguedTruth(const HiddenSource& source, const Machine& machine);
/// All that a benchmark hides: what `random` draws from, and these, which it never draws. Their size is the
/// RMS along their direction over the measurements of the session, without its mean.
const std::vector<SourceKind>& judgedKinds();

}  // namespace mm
