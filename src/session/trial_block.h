#pragma once
#include <optional>
#include <string>

namespace mm {

/// A block of a blind trial, as the name of its placement tells it: bags, tables and joined sessions carry
/// that name, and a plan asks its operator for a placement.
struct TrialBlock {
  std::string trial;        // tells trials apart: eight hexadecimal digits
  int number = 1, of = 1;   // of the blocks, from 1
  char state = 'A';         // A or B, of the controller; the key of the trial says in which it corrects
  std::string placement{};  // where the artifact stands, as outside of a trial; empty: the only one
};

/// "trial 3f2a91bc block 3 of 10 state A", with ": turned" where there is a placement.
std::string nameOf(const TrialBlock& block);
/// The block that a placement's name tells, also behind the name of a session that was joined; none: of no
/// trial.
std::optional<TrialBlock> trialBlock(const std::string& placement);

}  // namespace mm
