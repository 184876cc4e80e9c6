#pragma once
#include <string>

#include "verification/blind_verdict.h"

namespace mm {

/// A blind trial with its key: what is shown of it.
struct BlindReport {
  TrialBlocks blocks;
  LabelledTrial labelled;
  OpenedTrial opened;
  char on = 'A';                     // state in which the correction acted
  std::string session, calibration;  // files, for people
};

/// What `mm verify --blind --json` prints.
std::string blindJson(const BlindReport& report);
/// The same for people: the sentence, remarks, a line a block.
std::string blindText(const BlindReport& report);
/// The same as one HTML file without scripts or links to others: verdict, the blocks over time, figures.
/// @throw InputError: a file of the package is missing.
std::string blindPage(const BlindReport& report);

}  // namespace mm
