#include <algorithm>
#include <cmath>

#include "machine/units.h"
#include "report/text.h"
#include "report/text_parts.h"

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

std::string missingText(const CandidateResult& c, bool angular) {
  std::string text = "  " + spoken(c.effect) + "\n";
  for (const NamedValue& p : c.parameters)
    text += "    " + padded(p.name, 18) + withUncertainty(p.value, p.std, p.unit) + "\n";
  text += "    held-out RMS      " + length(c.heldOutBefore, angular) + " -> " +
          length(c.heldOutAfter, angular) +
          format("   odds %.2f\n", c.odds);
  for (const Confusable& other : c.confusableWith)
    text += "    or, as likely:    " + spoken(other.effect) +
            format(" (log-likelihood within %.1f)\n", other.delta);
  if (!c.cause.empty()) text += "    cause:  " + c.cause + "\n";
  if (!c.remedy.empty()) text += "    remedy: " + c.remedy + "\n";
  return text;
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

}  // namespace

std::string addCommand(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  const bool formula = !d.formulas.empty() && d.missing.empty();
  const EffectSpec* next = formula             ? &d.formulas.front().effect
                           : d.missing.empty() ? nullptr
                                               : &d.missing.front().effect;
  if (next == nullptr) return {};
  return "mm add " + quoted(session) + " --calibration " + quoted(calibration) + " " + quoted(next->yaml()) +
         " -o " + quoted(nextName(calibration));
}

std::string movesCommand(const std::string& session, const std::string& calibration) {
  return "mm diagnose " + quoted(session) + " --calibration " + quoted(calibration) + " --moves moves.yaml";
}

std::string diagnoseText(const Diagnosis& d, const std::string& session, const std::string& calibration) {
  std::string text = d.sentence + "\n";
  if (d.base.problem) {
    const ResidualFigures& f = d.base.figures;
    text += "\n  RMS " + length(d.angular ? f.rmsAngular : f.rms, d.angular) + ", held out " +
            length(d.angular ? f.heldOutRmsAngular : f.heldOutRms, d.angular) + ", repeatability " +
            length(d.base.repeatability, d.angular) + " (" + d.base.repeatabilityFrom + ")\n";
    text += "\n" + whereText(d.where);
  }
  if (!d.missing.empty()) {
    text += "\nMissing, in the order found\n";
    for (const CandidateResult& c : d.missing) text += missingText(c, d.angular);
  }
  if (!d.formulas.empty()) {
    text += "\nFormulas that explain it\n";
    for (const FormulaResult& f : d.formulas)
      text += "  " + f.effect.yaml() + "   held-out RMS " + length(f.heldOutBefore, d.angular) + " -> " +
              length(f.heldOutAfter, d.angular) + "\n";
  }
  if (!d.cannotShow.empty()) {
    constexpr std::size_t kShown = 8;
    text += "\nThis session could not have shown\n";
    for (std::size_t i = 0; i < std::min(kShown, d.cannotShow.size()); ++i)
      text += "  " + spoken(d.cannotShow[i].effect) + ": " + d.cannotShow[i].why +
              (d.cannotShow[i].moves.empty() ? "" : "; would: " + d.cannotShow[i].moves) + "\n";
    if (d.cannotShow.size() > kShown)
      text += format("  and %zu more (--json lists them)\n", d.cannotShow.size() - kShown);
  }
  if (!d.nextMeasurement.empty()) {
    constexpr std::size_t kShown = 6;
    text += format("\nNext measurement, to tell them apart: %zu targets\n", d.nextMeasurement.size());
    for (std::size_t i = 0; i < std::min(kShown, d.nextMeasurement.size()); ++i)
      text += "  " + moveText(d.nextMeasurement[i]) + "\n";
    if (d.nextMeasurement.size() > kShown) text += "  … (--json lists them)\n";
  }
  const std::string next = addCommand(d, session, calibration);
  if (!next.empty()) text += "\nType next:\n  " + next + "\n";
  return text;
}

}  // namespace mm
