#include "report/text_parts.h"

#include <algorithm>
#include <cmath>

#include "base/nearest_name.h"
#include "base/quantity_words.h"
#include "uncertainty/task_uncertainty.h"

namespace mm {
namespace {

/// Characters of a text, not bytes.
long characters(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
}

std::string explainedText(double share, double p) {
  const std::string chance = probabilityText(p);
  return format("%5.1f %%   p ", 100.0 * share) + (chance.front() == '<' ? "" : "= ") + chance;
}

}  // namespace

std::string length(double value, bool angular) {
  if (!std::isfinite(value)) return "-";
  const std::string said = errorInWords(value, angular);
  return said.front() == '<' ? said : format("%.4g ", value / unitOf(angular)) + nameOfUnit(angular);
}

std::string withUncertainty(double value, double std, const std::string& unit) {
  const std::string suffix = unit.empty() || unit == "1" ? "" : " " + unit;
  if (!std::isfinite(std) || !(std > 0.0)) return sixDigits(value) + suffix;
  const double wide = 2.0 * std;
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(wide)));
  if (decimals > 6 || decimals < -4 || std::abs(value) >= 1e7)
    return format("%.6g ± %.2g", value, wide) + suffix;
  return format("%.*f ± %.*f", std::max(0, decimals), value, std::max(0, decimals), wide) + suffix;
}

std::string padded(const std::string& text, int width) {
  return text + std::string(static_cast<std::size_t>(std::max(0L, width - characters(text))), ' ');
}

std::string wrapped(const std::string& head, const std::string& text) {
  constexpr long kWidth = 100;
  const long indent = characters(head);
  std::string lines = head;
  long used = indent;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t space = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, space - at);
    const long needed = characters(word);
    if (used > indent && used + 1 + needed > kWidth) {
      lines += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
      used = indent;
    }
    lines += (used > indent ? " " : "") + word;
    used += (used > indent ? 1 : 0) + needed;
    at = space + 1;
  }
  return lines + "\n";
}

std::string probabilityText(double p) { return p < 1e-6 ? "< 1e-6" : format("%.1g", p); }

std::vector<std::string> idleJoints(const Domain& domain) {
  std::vector<std::string> idle;
  for (std::size_t j = 0; j < domain.joints.size(); ++j)
    if (!(domain.upper[j] - domain.lower[j] > kStoodStill)) idle.push_back(domain.joints[j].name);
  return idle;
}

bool isOf(const EffectSpec& effect, const std::vector<std::string>& joints) {
  for (const auto& [key, value] : effect.keys)
    for (const std::string& item : value.items)
      if (std::find(joints.begin(), joints.end(), item) != joints.end()) return true;
  return false;
}

std::string idleText(const std::vector<std::string>& idle, std::size_t effects) {
  if (effects == 0) return {};
  return "  " + listOf(idle) + " never moved: " + std::to_string(effects) +
         (effects == 1 ? " effect of " : " effects of ") +
         (idle.size() > 1 ? "them or along them" : "it or along it") + " (--json lists them)\n";
}

std::string whereText(const std::vector<WhereItFails>& where) {
  std::string text;
  int shown = 0;
  for (const WhereItFails& w : where) {
    if (w.pValue > 0.05 || ++shown > 8) continue;
    text += "  " + padded(w.variable, 26) + padded(explainedText(w.share, w.pValue), 24) +
            explainedText(w.shareBeside, w.pBeside) + "\n";
  }
  if (text.empty()) return "Where it fails: no variable explains the residuals.\n";
  return "Where it fails: share of the residual variance\n  " + padded("", 26) + padded("alone", 24) +
         "in addition to those above\n" + text;
}

double timesRepeatability(const std::string& repeatabilityFrom, double chi2PerDof) {
  return repeatabilityFrom == "estimated" ? 0.0 : std::sqrt(chi2PerDof);
}

SizeOfResiduals sizeOfResiduals(const CalibrationResult& result, bool angular) {
  std::vector<double> sizes;
  for (int i = 0; i < result.residuals.size(); ++i)
    if (result.weight[i] > 0.0 && result.problem->rows()[static_cast<std::size_t>(i)].angular == angular)
      sizes.push_back(std::abs(result.residuals[i]));
  SizeOfResiduals size;
  size.count = static_cast<int>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  if (!sizes.empty()) size.max = sizes.back();
  for (const int percent : {50, 90, 95, 99})
    size.quantiles.emplace_back(percent, sizes.empty() ? kNotMeasured : quantileOf(sizes, 0.01 * percent));
  return size;
}

std::string sixDigits(double value) { return format("%.6g", value == 0.0 ? 0.0 : value); }

bool isRotary(const Domain& domain, const std::string& joint) {
  const int found = domain.findJoint(joint);
  return found >= 0 && domain.joints[static_cast<std::size_t>(found)].kind == JointKind::kRotary;
}

bool angularOnly(const CalibrationResult& result) {
  return !std::isfinite(result.figures.rms) && std::isfinite(result.figures.rmsAngular);
}

bool angularOnly(const Calibration& calibration) {
  return !std::isfinite(calibration.rms) && std::isfinite(calibration.rmsAngular);
}

}  // namespace mm
