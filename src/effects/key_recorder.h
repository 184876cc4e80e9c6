#pragma once
#include <optional>
#include <string>
#include <vector>

namespace mm {

/// What an effect asked of one of its keys while it was made.
struct KeyUse {
  enum class Kind {
    kJoint,
    kLinearJoint,
    kRotaryJoint,
    kDirection,          // a joint, or an axis of the workpiece
    kDirectionApproach,  // also along the approach
    kWorkpieceAxis,
    kSensor,
    kSensorPair,
    kSensorList,
    kCovariate,
    kFeature,
    kBall,
    kNumber,
    kInteger,
    kFlag,
    kWord,  // one of `words`
    kText,
    kNames,   // a list
    kNumbers  // a list
  };
  std::string key;
  Kind kind = Kind::kText;
  double lower = 0.0, upper = 0.0;    // kNumber, kInteger
  std::vector<std::string> words;     // kWord; or words that the key takes beside its kind ("unknown")
  std::optional<std::string> absent;  // what it means to leave it out; empty: it may not be left out
  bool list = false;                  // a list is taken beside
};

/// While one lives, every key that a SpecReader of this thread is asked for is noted, whether or not it is
/// there: so the catalogue tells the keys of an effect without anybody having written them down twice.
class KeyRecorder {
 public:
  KeyRecorder();
  ~KeyRecorder();
  KeyRecorder(const KeyRecorder&) = delete;
  KeyRecorder& operator=(const KeyRecorder&) = delete;

  const std::vector<KeyUse>& uses() const { return uses_; }  ///< in their order
  /// Notes a use with the recorder of this thread, if there is one; a key's first use says what it is.
  static void note(KeyUse use);
  /// That a list is taken too.
  static void noteList(const std::string& key);

 private:
  std::vector<KeyUse> uses_;
  std::vector<std::string> lists_;
  KeyRecorder* outer_;
};

}  // namespace mm
