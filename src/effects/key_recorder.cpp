#include "effects/key_recorder.h"

#include <algorithm>

namespace mm {
namespace {

thread_local KeyRecorder* innermost = nullptr;

}  // namespace

KeyRecorder::KeyRecorder() : outer_(innermost) { innermost = this; }

KeyRecorder::~KeyRecorder() { innermost = outer_; }

void KeyRecorder::note(KeyUse use) {
  if (innermost == nullptr) return;
  std::vector<KeyUse>& uses = innermost->uses_;
  const auto known =
      std::find_if(uses.begin(), uses.end(), [&](const KeyUse& u) { return u.key == use.key; });
  const std::vector<std::string>& lists = innermost->lists_;
  use.list = std::find(lists.begin(), lists.end(), use.key) != lists.end();
  if (known == uses.end()) {
    uses.push_back(std::move(use));
    return;
  }
  // `unknown` or a number: the word came first, what the key takes else comes after it
  if (known->kind == KeyUse::Kind::kWord && use.kind != KeyUse::Kind::kWord) {
    use.words.insert(use.words.begin(), known->words.begin(), known->words.end());
    *known = std::move(use);
  } else if (use.kind == KeyUse::Kind::kWord) {
    for (const std::string& word : use.words)
      if (std::find(known->words.begin(), known->words.end(), word) == known->words.end())
        known->words.push_back(word);
  }
}

void KeyRecorder::noteList(const std::string& key) {
  if (innermost != nullptr) innermost->lists_.push_back(key);
}

}  // namespace mm
