#include "diagnosis/wording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "diagnosis/noise_words.h"

namespace mm {
namespace {

std::string fileName(const std::string& path) { return std::filesystem::path(path).filename().string(); }

std::string alongWords(const Diagnosis& d, const std::string& direction) {
  return direction == "approach"   ? "along the approach"
         : isAngular(d, direction) ? "of " + direction
                                   : "along " + direction;
}

/// "held-out RMS 0.93 -> 0.32 um": without what was found, and with all of it, both by one definition.
std::string heldOutWords(const Diagnosis& d) {
  double before = d.heldOutBefore, after = d.heldOut;
  if (!positive(before) && !d.missing.empty()) before = d.missing.front().heldOutBefore;
  if (!positive(before) && !d.profiles.empty()) before = d.profiles.front().heldOutBefore;
  if (!positive(after) && !d.missing.empty()) after = d.missing.back().heldOutAfter;
  if (!positive(after) && !d.profiles.empty()) after = d.profiles.back().heldOutAfter;
  if (!positive(before) || !positive(after)) return {};
  return "held-out RMS " + shortNumber(before / unitOf(d.angular)) + " -> " + errorInWords(after, d.angular);
}

/// What was named predicts what it was not fitted to no better than the model without it did.
std::string noBetterWords(const Diagnosis& d) {
  if (!positive(d.heldOutBefore) || !positive(d.heldOut) || d.heldOut < d.heldOutBefore) return {};
  return " But held-out measurements are not predicted better: the named cause may hold for this session "
         "only.";
}

/// Rivals that further data of the same kinds would tell from the named one.
std::vector<const Confusable*> openRivals(const CandidateResult& c) {
  std::vector<const Confusable*> open;
  for (const Confusable& rival : c.confusableWith)
    if (!rival.same && rival.notRecorded.empty()) open.push_back(&rival);
  return open;
}

/// "; the listed moves would": whether they separate the named effects from their rivals.
std::string listedMovesWords(const Diagnosis& d) {
  if (d.nextMeasurement.empty()) return {};
  std::vector<EffectSpec> told;
  bool all = true;
  int times = 1;
  for (const CandidateResult& c : d.missing)
    for (const Confusable* rival : openRivals(c)) {
      if (rival->repeats == 0) {
        all = false;
        continue;
      }
      told.push_back(rival->effect);
      times = std::max(times, rival->repeats);
    }
  if (told.empty()) return {};
  return "; the listed moves" + (d.moveChange.empty() ? "" : ", with " + d.moveChange + ",") + " would" +
         (times > 1 ? ", measured " + std::to_string(times) + " times" + (all ? "" : ",") : "") +
         (all ? "" : " separate only " + listInWords(told));
}

/// Whose it is, where more than one thing was changed and measured again; else nothing.
std::string whose(const Diagnosis& d, const EffectSpec& effect) {
  if (d.base.problem == nullptr) return {};
  const Session& session = d.base.problem->session();
  if (session.recordings.empty() && session.placements.empty() && session.artifact.styli.size() < 2)
    return {};
  const std::string owner = ownerOf(effect, d);
  const std::size_t n = session.recordings.size();
  for (std::size_t r = 1; r < n; ++r)
    if (owner == "session " + session.recordings[r].source)
      return " (it began between " + fileName(session.recordings[r - 1].source) + " and " +
             fileName(session.recordings[r].source) + ")";
  return " (of " + std::string(owner == "machine" ? "the " : "") + owner + ")";
}

/// "backlash of x, 2.06 ± 0.06 um (k = 2), odds about 1000 to 1"
std::string surely(const CandidateResult& c, const Diagnosis& d) {
  const std::string size = withFactor(sizeInWords(c, d.angular));
  return foundInWords(c) + whose(d, c.effect) + (size.empty() ? "" : ", " + size) + ", odds " +
         oddsInWords(c.odds);
}

/// "either backlash of x (2.06 ± 0.06 um, k = 2; odds 3 to 2) or trigger delay (1 to 3)"
std::string eitherOr(const CandidateResult& c, const Diagnosis& d) {
  std::string size = sizeInWords(c, d.angular);
  if (size.find("±") != std::string::npos) size += ", k = 2";
  std::string text = "either " + foundInWords(c) + whose(d, c.effect) + " (" + size +
                     (size.empty() ? "" : "; ") + "odds " + oddsInWords(c.odds) + ")";
  for (const Confusable* rival : openRivals(c))
    text += " or " + inWords(rival->effect) + whose(d, rival->effect) + " (" + oddsInWords(rival->odds) + ")";
  return text;
}

std::string missingSentence(const Diagnosis& d) {
  std::string sure, open;
  for (const CandidateResult& c : d.missing) {
    std::string& text = hasOpenRivals(c) ? open : sure;
    text += (text.empty() ? "" : "; ") + (hasOpenRivals(c) ? eitherOr(c, d) : surely(c, d));
  }
  const std::string heldOut = heldOutWords(d);
  std::string text = sure.empty() ? "" : "Missing: " + sure;
  if (open.empty()) return text + (heldOut.empty() ? "" : "; " + heldOut) + "." + noBetterWords(d);
  if (!sure.empty()) text += ". In addition ";
  text += (sure.empty() ? capitalized(open) : open) + ": these data do not separate them";
  text += listedMovesWords(d);
  return text + (heldOut.empty() ? "" : ". " + capitalized(heldOut)) + "." + noBetterWords(d);
}

/// Where a named effect is the same as another, or another that was not recorded may be in its place.
std::string rivalRemarks(const CandidateResult& c) {
  std::string text;
  std::vector<EffectSpec> alike = {c.effect};
  std::vector<std::string> inputs;
  for (const Confusable& rival : c.confusableWith) {
    if (rival.same) alike.push_back(rival.effect);
    const bool told = std::find(inputs.begin(), inputs.end(), rival.notRecorded) != inputs.end();
    if (!rival.same && !rival.notRecorded.empty() && !told) inputs.push_back(rival.notRecorded);
  }
  if (alike.size() > 1)
    text += " " + capitalized(listInWords(alike)) +
            " do the same wherever measurements of this kind reach: none separates them.";
  for (const std::string& input : inputs) {
    std::vector<EffectSpec> hidden;
    for (const Confusable& rival : c.confusableWith)
      if (!rival.same && rival.notRecorded == input) hidden.push_back(rival.effect);
    text += " " + capitalized(listInWords(hidden)) + " cannot be excluded: " + inputInWords(input) +
            " was not recorded.";
  }
  return text;
}

/// Inputs that were made up and on which a named cause, or a rival of one, rests.
std::string assumptions(const Diagnosis& d) {
  std::string text;
  for (const MissingInput& input : d.missingInputs) {
    if (input.assumed.empty()) continue;
    const auto concerned = [&](const EffectSpec& effect) {
      return std::find(input.effects.begin(), input.effects.end(), effect) != input.effects.end();
    };
    const bool matters = std::any_of(d.missing.begin(), d.missing.end(), [&](const CandidateResult& c) {
      return concerned(c.effect) || std::any_of(c.confusableWith.begin(), c.confusableWith.end(),
                                                [&](const Confusable& r) { return concerned(r.effect); });
    });
    if (matters) text += " " + capitalized(inputInWords(input.input)) + " was assumed " + input.assumed + ".";
  }
  return text;
}

std::string remarks(const Diagnosis& d) {
  std::string text;
  for (const CandidateResult& c : d.missing)
    text += rivalRemarks(c) + (c.looksTheSame.empty() ? "" : " " + c.looksTheSame);
  return text + assumptions(d);
}

/// "up to 1.41 ± 0.20 um (k = 2) at x = -16 mm", where the curve is largest for sure: at its ends it may be
/// large and not known.
std::string peakOf(const Diagnosis& d, const ProfileResult& p) {
  const std::size_t n = p.variables.size();
  const std::vector<double>* peak = nullptr;
  const auto atLeast = [n](const std::vector<double>& at) { return std::abs(at[n]) - 2.0 * at[n + 1]; };
  for (const std::vector<double>& point : p.curve)
    if (point.size() == n + 2 && std::isfinite(point[n]) &&
        (peak == nullptr || atLeast(point) > atLeast(*peak)))
      peak = &point;
  if (peak == nullptr) return {};
  std::string text = "up to " +
                     withFactor(expanded((*peak)[n], (*peak)[n + 1], nameOfUnit(isAngular(d, p.direction)))) +
                     " at ";
  for (std::size_t i = 0; i < n; ++i) {
    const std::string unit = i < p.units.size() ? p.units[i] : "";
    text += (i == 0 ? "" : ", ") + (p.variables[i] == "t" ? "time" : p.variables[i]) + " = " +
            shortNumber((*peak)[i]) + (unit.empty() || unit == "1" ? "" : " " + unit);
  }
  return text;
}

/// "backlash of x, … ; either backlash of y … or lost motion of y ….": what was found, each with its odds.
std::string foundAll(const Diagnosis& d) {
  std::string text;
  for (const CandidateResult& c : d.missing)
    text += (text.empty() ? "" : "; ") + (hasOpenRivals(c) ? eitherOr(c, d) : surely(c, d));
  return text + ".";
}

std::string unknownSentence(const Diagnosis& d) {
  std::string text;
  // what has a name comes first where it does more
  const bool namedFirst =
      !d.missing.empty() && (d.profiles.empty() || d.missing.front().gain > d.profiles.front().gain);
  if (namedFirst) text = "Missing: " + foundAll(d) + " In addition ";
  for (std::size_t i = 0; i < d.profiles.size(); ++i) {
    const ProfileResult& p = d.profiles[i];
    if (i == 0)
      text += namedFirst ? "an error " : "An error ";
    else
      text += " And one ";
    text += alongWords(d, p.direction) + " that depends on " + variablesInWords(p);
    if (i == 0) text += ", and that no effect of the catalogue explains";
    const std::string peak = peakOf(d, p);
    text += ": " + (peak.empty() ? "" : peak + ", ") + "odds " + oddsInWords(p.odds);
    if (i + 1 == d.profiles.size())
      if (const std::string heldOut = heldOutWords(d); !heldOut.empty()) text += "; " + heldOut;
    text += ".";
  }
  if (d.profiles.empty()) {
    constexpr double kSignificant = 1e-3;  // chance, corrected for the number of variables asked
    std::vector<std::string> on;
    for (const WhereItFails& w : d.where)
      if (w.pBeside < kSignificant && on.size() < 3) on.push_back(w.variable);
    text += std::string(namedFirst ? "structure" : "Structure") +
            " is left that no effect of the catalogue explains";
    for (std::size_t i = 0; i < on.size(); ++i) text += (i == 0 ? "; it depends on " : ", ") + on[i];
    text += ".";
  }
  for (const FormulaResult& f : d.formulas)
    text += " The formula " + inWords(f.effect) + " describes it as well.";
  if (!d.missing.empty() && !namedFirst) text += " Found on the way: " + foundAll(d);
  return text + (d.profiles.empty()       ? " Look for its cause."
                 : d.profiles.size() == 1 ? " Add it as a profile, or look for its cause."
                                          : " Add them as profiles, or look for their causes.");
}

std::string doubtOfOdds(const Diagnosis& d) {
  if (!(d.chainsDiffer > 0.0) || (d.missing.empty() && d.profiles.empty() && d.possible.empty())) return {};
  return " Two searches differ by up to " + shortNumber(std::ceil(100.0 * d.chainsDiffer) / 100.0) +
         " in a probability: these odds are known no better.";
}

}  // namespace

std::string capitalized(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

bool hasOpenRivals(const CandidateResult& missing) { return !openRivals(missing).empty(); }

std::string nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kQuestion:
      return "question";
    case Verdict::kInsufficientData:
      return "insufficient_data";
    case Verdict::kUnknownEffect:
      return "unknown_effect";
    case Verdict::kConfusable:
      return "confusable";
    case Verdict::kMissingEffect:
      return "missing_effect";
    case Verdict::kScatter:
      return "scatter";
    default:
      return "explained";
  }
}

std::string sentenceOf(const Diagnosis& d) {
  switch (d.verdict) {
    case Verdict::kQuestion: {
      std::string text = "A question must be answered before any cause can be named:";
      for (const Doubt& q : d.questions) text += " " + q.question;
      return text + " Correct the session's file, or the mapping of its columns, then diagnose again.";
    }
    case Verdict::kUnknownEffect:
      return unknownSentence(d) + remainderSentence(d) + remarks(d) + doubtOfOdds(d);
    case Verdict::kConfusable:
    case Verdict::kMissingEffect:
      return missingSentence(d) + remainderSentence(d) + remarks(d) + doubtOfOdds(d);
    case Verdict::kScatter:
      return scatterSentence(d) + variationSentence(d) + possibleSentence(d) + doubtOfOdds(d) +
             driftSentence(d);
    case Verdict::kExplained:
      return explainedSentence(d) + possibleSentence(d) + doubtOfOdds(d) + driftSentence(d);
    default:
      return "The model cannot be fitted to this session: measure more, or take effects out of the model.";
  }
}

std::string whyNotApart(const Confusable& rival) {
  if (rival.same) return "does the same wherever measurements of this kind reach: none separates them";
  if (rival.notRecorded.empty()) return {};
  return "cannot be excluded: " + inputInWords(rival.notRecorded) + " was not recorded";
}

}  // namespace mm
