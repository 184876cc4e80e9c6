#include <algorithm>
#include <cmath>

#include "base/quantity_words.h"
#include "diagnosis/noise_words.h"
#include "diagnosis/verdict.h"
#include "diagnosis/wording.h"
#include "report/symbols_of.h"
#include "report/text.h"
#include "report/text_parts.h"
#include "uncertainty/standard_tests.h"
#include "workflow/learning.h"

namespace mm {
namespace {

/// A word of a shell's line: quoted where it must be.
std::string quoted(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+-=@%,";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos && word.front() != '-')
    return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// Several bags, "a.bag:b.bag", as they are typed.
std::string bagsTyped(const std::string& session) {
  constexpr const char kBetween[] = ".bag:";
  std::string typed;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = session.find(kBetween, begin)) != std::string::npos;
       begin = end + sizeof kBetween - 1)
    typed += quoted(session.substr(begin, end + sizeof kBetween - 2 - begin)) + " ";
  return typed + quoted(session.substr(begin));
}

/// "    cause             play in the drive": a label, and what belongs to it; nothing where that is empty.
std::string entry(const std::string& label, const std::string& text) {
  return text.empty() ? "" : wrapped("    " + padded(label, 18), text);
}

std::string missingText(const CandidateResult& c, bool angular, const ErrorSymbols& symbols) {
  std::string text = "  " + inWords(c.effect, symbols) + "\n";
  for (const NamedValue& p : c.parameters)
    text += entry(p.name, p.std > 0.0 ? expanded(p.value, p.std, p.unit) : "not determined by this session");
  text += entry("odds", oddsInWords(c.odds));
  text += entry("held-out RMS", length(c.heldOutBefore, angular) + " -> " + length(c.heldOutAfter, angular));
  std::string label = "or instead";
  for (const Confusable& rival : c.confusableWith) {
    const std::string why = whyNotApart(rival);
    text += entry(label, inWords(rival.effect, symbols) +
                             (why.empty() ? ", " + oddsInWords(rival.odds) : "; " + why) +
                             (rival.moves.empty() ? "" : "; to separate them: " + rival.moves));
    label.clear();
  }
  return text + entry("looks the same", c.looksTheSame) + entry("cause", c.cause) + entry("remedy", c.remedy);
}

std::string possibleText(const Diagnosis& d) {
  if (d.possible.empty()) return {};
  std::string text = "\nNot established, and not excluded\n";
  for (const PossibleCause& p : d.possible)
    text += "  " + inWords(p.effect, symbolsOf(d)) + "\n" + entry("odds", oddsInWords(p.odds)) +
            entry("would show it", p.shownBy);
  return text;
}

std::string driftText(const Diagnosis& d) {
  if (d.drift.empty()) return {};
  std::string text = "\nDrift\n";
  for (const DriftResult& drift : d.drift) {
    text += entry(drift.direction, length(drift.std, isAngular(d, drift.direction)) + " RMS" +
                                       (drift.timeConstant > 0.0 && std::isfinite(drift.timeConstant)
                                            ? ", time constant " + durationInWords(drift.timeConstant)
                                            : std::string()));
    std::string label = "perhaps";
    for (const DriftResult::Perhaps& other : drift.perhaps) {
      text += entry(label,
                    inWords(other.effect) + ", odds " + oddsInWords(other.odds) +
                        (other.share > 0.0 ? format("; it would explain %.0f %% of it", 100.0 * other.share)
                                           : std::string()));
      label.clear();
    }
    text += entry("to do", drift.inWords.empty() ? driftAdvice(drift) : drift.inWords);
  }
  return text;
}

std::string artifactText(const Diagnosis& d) {
  if (d.artifactScatter.empty()) return {};
  std::string text = "\nScatter of places\n";
  for (const ArtifactScatter& a : d.artifactScatter)
    text += entry(a.what, sizeOfScatter(a) + (a.inWords.empty() ? "" : ": " + a.inWords));
  return text;
}

std::string inputsText(const Diagnosis& d) {
  if (d.missingInputs.empty()) return {};
  std::vector<std::pair<std::string, std::string>> lines;  // what follows, and from which inputs
  for (const MissingInput& input : d.missingInputs) {
    std::string what = input.assumed.empty() ? "" : ": assumed " + input.assumed;
    if (input.assumed.empty() && !input.effects.empty())
      what = ": " + listInWords(input.effects) + " cannot be excluded without it";
    if (!lines.empty() && lines.back().first == what)
      lines.back().second += ", " + input.input;
    else
      lines.emplace_back(what, input.input);
  }
  std::string text = "\nNot recorded\n";
  for (const auto& [what, inputs] : lines) text += wrapped("  ", inputs + what);
  return text;
}

bool repeatabilityKnown(const Diagnosis& d) {
  return d.base.repeatabilityFrom == "declared" || d.base.repeatabilityFrom == "repeated";
}

std::string foundNoise(const Diagnosis& d) {
  const double unit = unitOf(d.angular);
  return expanded(d.noise / unit, d.noiseStd / unit, nameOfUnit(d.angular));
}

std::string figuresText(const Diagnosis& d) {
  const ResidualFigures& f = d.base.figures;
  std::string text = "\n  RMS " + length(d.angular ? f.rmsAngular : f.rms, d.angular) + ", held out " +
                     length(d.angular ? f.heldOutRmsAngular : f.heldOutRms, d.angular);
  if (d.heldOut > 0.0 && !(d.missing.empty() && d.profiles.empty()))
    text += "; with what was found, held out " + length(d.heldOut, d.angular);
  text +=
      "\n  repeatability " +
      (repeatabilityKnown(d)
           ? length(d.base.repeatability, d.angular) + " (" +
                 (d.base.repeatabilityFrom == "repeated" ? "from repeated measurements" : "declared") + ")"
           : "not known");
  if (d.noise > 0.0) text += ", noise found " + foundNoise(d);
  if (d.asked < d.residuals)
    text += format(
        "\n  the search used %d of %d residuals, in stretches over the whole session; sizes are from all "
        "residuals",
        d.asked, d.residuals);
  if (d.chainsDiffer > 0.0)
    text += format(
        "\n  the two chains of the sample do not agree: a probability may be wrong by %.2g; diagnose again "
        "with another --seed",
        d.chainsDiffer);
  if (d.tailDof > 0.0)
    text += format("\n  the noise has heavy tails: Student's t of %.2g degrees of freedom", d.tailDof);
  if (d.resolution > 0.0)
    text += "\n  most readings agree within the resolution of " + length(d.resolution, d.angular) +
            ": they were treated as spread over a quarter of it";
  if (d.outliers.readings > 0) text += "\n  " + outliersInWords(d);
  for (const NotJudged& n : d.notJudged)
    text += format("\n  %d observation%s not evaluated: ", n.observations,
                   n.observations == 1 ? " is" : "s are") +
            (n.directionKnown ? "how far " + n.joint + " had come since its last reversal"
                              : "the direction from which " + n.joint + " arrived") +
            " is unknown; move it before the first reading";
  return text + "\n  ± is the expanded uncertainty, k = 2\n";
}

std::string moveText(const Move& move) {
  std::string text;
  for (const auto& [name, value] : move.values)
    text += format("%s%s %.4g", text.empty() ? "" : ", ", name.c_str(), value);
  for (const auto& [name, word] : move.words) text += (text.empty() ? "" : ", ") + name + " " + word;
  if (move.approach.size() == 3)
    text += format("%sapproach (%.2f, %.2f, %.2f)", text.empty() ? "" : ", ", move.approach[0],
                   move.approach[1], move.approach[2]);
  return text;
}

/// The next name for a file: c.yaml -> c2.yaml -> c3.yaml.
std::string nextName(const std::string& file) {
  const std::size_t dot = file.rfind(".yaml") != std::string::npos ? file.rfind(".yaml") : file.size();
  std::size_t digits = dot;
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(file[digits - 1])) != 0 && dot - digits < 4)
    --digits;
  const int number = digits < dot ? std::stoi(file.substr(digits, dot - digits)) : 1;
  return file.substr(0, digits) + std::to_string(number + 1) +
         (dot < file.size() ? file.substr(dot) : ".yaml");
}

/// Effects that stayed hidden for the same reason, and that the same would show, on one line; those of joints
/// that never moved on one line too.
std::string cannotShowText(const Diagnosis& d) {
  if (d.cannotShow.empty()) return {};
  constexpr std::size_t kShown = 6, kNames = 3;
  std::vector<std::pair<const CannotShow*, std::vector<EffectSpec>>> lines;
  const std::vector<std::string> idle =
      d.base.problem ? idleJoints(d.base.problem->model().domain()) : std::vector<std::string>();
  std::size_t ofIdle = 0;
  for (const CannotShow& c : d.cannotShow) {
    if (isOf(c.effect, idle)) {
      ++ofIdle;
      continue;
    }
    const auto same = std::find_if(lines.begin(), lines.end(), [&](const auto& line) {
      return line.first->why == c.why && line.first->moves == c.moves;
    });
    if (same == lines.end())
      lines.push_back({&c, {c.effect}});
    else
      same->second.push_back(c.effect);
  }
  std::string text = "\nThis session cannot exclude\n" + idleText(idle, ofIdle);
  std::size_t more = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& [of, effects] = lines[i];
    if (i >= kShown)
      more += effects.size();
    else
      text += wrapped("  ", listInWords(effects, kNames) + ": " + of->why +
                                (of->moves.empty() ? "" : "; would show it: " + of->moves));
  }
  return text + (more > 0 ? format("  and %zu more (--json lists them)\n", more) : "");
}

std::string addLine(const EffectSpec& effect, const std::string& session, const std::string& calibration) {
  return "mm add " + bagsTyped(session) + " --calibration " + quoted(calibration) + " " +
         quoted(effect.yaml()) + " -o " + quoted(nextName(calibration));
}

/// The line to type where nothing is to be added, below what it is for.
std::string afterwards(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  if (d.verdict == Verdict::kQuestion)
    return "\nWhen the session is corrected:\n  " + diagnoseCommand(session, calibration) + "\n";
  if (d.verdict == Verdict::kInsufficientData)
    return "\nType next, to see what the session can show:\n  mm check " + bagsTyped(session) + "\n";
  if (d.verdict == Verdict::kExplained && d.variations.empty())
    return "\nType next:\n  mm promote " + quoted(calibration) + "\n";
  if (d.verdict == Verdict::kScatter && !d.outliers.inCommon.empty())
    return "\nType next:\n  " + diagnoseCommand(session, calibration) + " --keep-outliers\n";
  if (const ArtifactScatter* of = ofAnAxis(d);
      d.verdict == Verdict::kScatter && of != nullptr && !of->correctedBy.type.empty())
    return "\nType next:\n  " + addLine(of->correctedBy, session, calibration) + "\n";
  if (d.verdict == Verdict::kScatter && !repeatabilityKnown(d) && !d.angular)
    return "\nWith the standard deviation, um, of the twenty readings in place of STD:\n  " +
           diagnoseCommand(session, calibration) + " --repeatability-um STD\n";
  return "\nType next, to see what is left over each variable:\n  mm report " + bagsTyped(session) +
         " --calibration " + quoted(calibration) + " -o report.html\n";
}

/// The line to type next: every verdict has one.
std::string nextLines(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  const bool measure = d.verdict == Verdict::kConfusable && !d.nextMeasurement.empty();
  const std::string add = d.verdict == Verdict::kQuestion ? "" : addCommand(d, session, calibration);
  if (add.empty() && !measure) return afterwards(d, session, calibration);
  std::string text;
  if (measure)
    text =
        "\nNext, write a plan of the moves and measure it:\n  " + movesCommand(session, calibration) + "\n";
  const bool certain = !std::all_of(d.missing.begin(), d.missing.end(), hasRivals);
  if (!add.empty())
    text += (!measure  ? "\nType next:\n  "
             : certain ? "\nAdd the certain effect now:\n  "
                       : "\nOr, without measuring, add the most probable:\n  ") +
            add + "\n";
  return text;
}

}  // namespace

std::string addCommand(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  const EffectSpec* next = nextToAdd(d);
  return next == nullptr ? std::string() : addLine(*next, session, calibration);
}

std::string diagnoseCommand(const std::string& session, const std::string& calibration) {
  return "mm diagnose " + bagsTyped(session) + " --calibration " + quoted(calibration);
}

std::string movesCommand(const std::string& session, const std::string& calibration) {
  return diagnoseCommand(session, calibration) + " --moves moves.yaml";
}

std::string errorText(const Diagnosis& d) {
  if (!d.base.problem) return {};
  const ResidualFigures& f = d.base.figures;
  return "RMS " + length(d.angular ? f.rmsAngular : f.rms, d.angular) +
         (d.noise > 0.0 ? ", noise " + foundNoise(d) + " (k = 2)" : "");
}

std::string diagnoseText(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  std::string text = d.sentence + "\n";
  if (d.base.problem)
    for (const StandardTest& test : standardTests(d.base.problem->session())) text += test.inWords + "\n";
  if (d.verdict == Verdict::kQuestion)
    return text + (d.base.problem ? figuresText(d) : "") + nextLines(d, session, calibration);
  if (d.base.problem) text += figuresText(d) + "\n" + whereText(d.where);
  std::string named, oneOf;
  for (const CandidateResult& c : d.missing)
    (hasOpenRivals(c) ? oneOf : named) += missingText(c, d.angular, symbolsOf(d));
  if (!named.empty()) text += "\nMissing, in the order found\n" + named;
  if (!oneOf.empty()) text += "\nOne of several acts, and these data do not tell which\n" + oneOf;
  if (!d.profiles.empty()) {
    text += "\nErrors that no effect of the catalogue explains\n";
    for (const ProfileResult& p : d.profiles) text += profileText(d, p);
  }
  if (!d.formulas.empty()) {
    text += "\nThe same as a formula\n";
    for (const FormulaResult& f : d.formulas)
      text += "  " + f.effect.yaml() + "   held-out RMS " + length(f.heldOutBefore, d.angular) + " -> " +
              length(f.heldOutAfter, d.angular) + "\n";
  }
  text += possibleText(d) + driftText(d) + artifactText(d) + inputsText(d);
  text += cannotShowText(d);
  if (!d.nextMeasurement.empty()) {
    constexpr std::size_t kShown = 6;
    text += format("\nNext measurement, to separate them: %zu targets", d.nextMeasurement.size()) +
            (d.moveChange.empty() ? "" : ", with " + d.moveChange) + "\n";
    for (std::size_t i = 0; i < std::min(kShown, d.nextMeasurement.size()); ++i)
      text += "  " + moveText(d.nextMeasurement[i]) + "\n";
    if (d.nextMeasurement.size() > kShown) text += "  … (--json lists them)\n";
  }
  return text + nextLines(d, session, calibration);
}

}  // namespace mm
